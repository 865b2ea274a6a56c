#include "lumesh/lattice/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "hexahedra.hpp"
#include "labelled_lattice.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/opening_sizes.hpp"
#include "lumesh/domain/patch_names.hpp"
#include "lumesh/fitting/boundary_choice.hpp"
#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/fitting/fit.hpp"
#include "lumesh/parallel/loops.hpp"
#include "notes.hpp"
#include "refinement.hpp"
#include "size_grid.hpp"

namespace lumesh {

namespace {

MixedMesh to_mixed_mesh(fitting::WorkMesh& mesh, const fitting::BoundaryModel& boundary,
                        const ImageDomain& domain) {
  MixedMesh out;
  out.points = std::move(mesh.positions);
  out.tetrahedra = std::move(mesh.tets);
  out.tetrahedron_labels.resize(out.tetrahedra.size());
  parallel::for_each_index(out.tetrahedra.size(), [&](std::size_t t) {
    out.tetrahedron_labels[t] = domain.label_of(mesh.materials[t]);
  });
  PatchAssignment patches = name_patches(boundary.triangles, out.points, domain);
  out.info.patches = std::move(patches.patches);
  out.info.label_names = std::move(patches.label_names);
  out.triangle_patches = std::move(patches.of_triangle);
  out.triangles.resize(boundary.triangles.size());
  parallel::for_each_index(out.triangles.size(),
                           [&](std::size_t t) { out.triangles[t] = boundary.triangles[t].vertices; });
  return out;
}

constexpr int kMaxRescues = 2;  ///< Finer lattices around lost labels.

/// Numbers of voxels of each material on the kept side of the cut planes.
std::vector<double> object_voxels(const LabelImage& image, const ImageDomain& domain) {
  std::vector<double> voxels = count_kept_voxels(image, domain.cut_planes());
  if (std::ranges::all_of(voxels, [](double count) { return count <= 0; }))
    throw Error(ErrorKind::kBadInput,
                "nothing is left of the object: no voxel has a label on the kept side of the cut planes");
  return voxels;
}

/// A lattice as fine as the options ask for, with the material of every tetrahedron.
fitting::WorkMesh make_labelled_lattice(const LabelImage& image, const ImageDomain& domain,
                                        const LatticeOptions& options, const OpeningSizes& at_openings,
                                        const std::vector<double>& voxels, Context& context,
                                        LatticeReport& report) {
  const double coarsest_mm =
      SizeGrid::boundary_spacing_mm(image, domain, options) * std::exp2(options.coarsening);
  const LatticeFrame frame =
      make_lattice_frame(domain, coarsest_mm, options.coarsening + options.max_refinement);
  const auto total = static_cast<std::size_t>(std::ceil(std::accumulate(voxels.begin(), voxels.end(), 0.0)));
  const SizeGrid sizes = context.phase(
      "sizes", [&] { return SizeGrid(image, domain, options, coarsest_mm, total, at_openings); });
  report.levels_given_up = sizes.levels_given_up();
  bcc::Lattice lattice = context.phase("refinement", [&] { return refined_lattice(frame, domain, sizes); });
  report.lattice_tetrahedra = lattice.size();
  return context.phase("labels", [&] { return make_work_mesh(std::move(lattice), frame, domain); });
}

/// Changes materials until every label's boundary is a manifold.
void make_manifold(fitting::WorkMesh& mesh, const ImageDomain& domain, Context& context,
                   LatticeReport& report) {
  report.relabelled = context.phase("boundary", [&] { return fitting::choose_boundary(mesh, domain); });
}

/// The boundary between materials; tetrahedra of the background are dropped.
fitting::BoundaryModel extract_boundary(fitting::WorkMesh& mesh, const ImageDomain& domain) {
  fitting::BoundaryModel boundary = fitting::find_boundary(mesh, domain);
  std::vector<std::uint8_t> keep(mesh.tets.size());
  parallel::for_each_index(keep.size(),
                           [&](std::size_t t) { keep[t] = domain.is_meshed(mesh.materials[t]) ? 1 : 0; });
  fitting::drop_tetrahedra(mesh, boundary, keep);
  return boundary;
}

/// Asks for a finer lattice around lost labels; false if there is nothing to gain.
bool raise_fidelity(LatticeOptions& options, const std::vector<Label>& lost) {
  constexpr double kHigh = 0.9, kHighest = 0.97;
  const double usual = options.cells_per_diameter > 0
                           ? std::max(options.fidelity, 1 - 0.5 / options.cells_per_diameter)
                           : options.fidelity;
  bool raised = false;
  for (const Label label : lost) {
    double& fidelity = options.label_fidelity.try_emplace(label, usual).first->second;
    if (fidelity >= kHighest) continue;
    fidelity = fidelity < kHigh ? kHigh : kHighest;
    raised = true;
  }
  return raised;
}

fitting::FitReport fit_boundary(fitting::WorkMesh& mesh, fitting::BoundaryModel& boundary,
                                const LabelImage& image, const ImageDomain& domain,
                                const LatticeOptions& options, Context& context) {
  if (mesh.tets.empty())
    throw Error(
        ErrorKind::kBadInput,
        "the object is too small for the lattice; choose a smaller `edge_length` or a higher `fidelity`");
  const fitting::FitOptions fit{
      options.min_dihedral_deg, options.max_dihedral_deg,
      context.phase("probes", [&] { return fitting::boundary_probes(image, domain); })};
  return context.phase("fit", [&] { return fitting::fit_to_domain(mesh, boundary, image, domain, fit); });
}

LatticeResult mesh_once(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                        const OpeningSizes& at_openings, const std::vector<double>& voxels,
                        Context& context) {
  LatticeResult result;
  LatticeOptions finer = options;
  fitting::WorkMesh mesh;
  fitting::BoundaryModel boundary;
  int rescues = 0;
  do {
    mesh = make_labelled_lattice(image, domain, finer, at_openings, voxels, context, result.report);
    make_manifold(mesh, domain, context, result.report);
    boundary = context.phase("model", [&] { return extract_boundary(mesh, domain); });
  } while (rescues++ < kMaxRescues && raise_fidelity(finer, lost_labels(mesh, domain, voxels)));
  const fitting::FitReport fit = fit_boundary(mesh, boundary, image, domain, options, context);
  add_shortcomings(mesh, fit, domain, options, voxels, result.report);
  result.mesh = to_mixed_mesh(mesh, boundary, domain);
  return result;
}

}  // namespace

LatticeResult mesh_lattice(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                           Context& context) {
  options.validate();
  options.require_labels_of(image);
  const std::vector<double> voxels = context.phase("count", [&] { return object_voxels(image, domain); });
  std::size_t max_cells = 0;
  auto best = best_at_openings(
      domain, context,
      [&](const OpeningSizes& sizes) {
        LatticeResult made = mesh_once(image, domain, options, sizes, voxels, context);
        if (sizes.sizes().empty()) max_cells = max_cells_made_again(made.mesh.tetrahedra.size());
        return made;
      },
      [](const OpeningSizes& sizes, const LatticeResult& made) { return sizes.faults_in(made.mesh.view()); },
      [&](const LatticeResult& made) { return made.mesh.tetrahedra.size() <= max_cells; },
      [](const LatticeResult&) { return true; });
  LatticeResult result = std::move(best.mesh);
  result.report.complete = best.is_complete;
  if (options.mixed)
    context.phase("hexahedra", [&] { merge_hexahedra(result.mesh, domain.frame().direction); });
  return result;
}

}  // namespace lumesh
