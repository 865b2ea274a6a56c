#include "lumesh/lattice/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <sstream>

#include "boundary_choice.hpp"
#include "fit.hpp"
#include "hexahedra.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/patch_names.hpp"
#include "lumesh/parallel/loops.hpp"
#include "refinement.hpp"
#include "size_grid.hpp"
#include "work_mesh.hpp"

namespace lumesh {

namespace {

MixedMesh to_mixed_mesh(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain) {
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

constexpr int kMaxRescues = 2;

struct BuiltLattice {
  WorkMesh mesh;
  BoundaryModel boundary;
};

/// From sizes to a labelled mesh with a manifold boundary, not yet fitted.
BuiltLattice build_lattice(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                           std::size_t object_voxels, Context& context, LatticeReport& report) {
  const double coarsest_mm = boundary_spacing_mm(options, domain) * std::exp2(options.coarsening);
  const LatticeFrame frame =
      make_lattice_frame(domain, coarsest_mm, options.coarsening + options.max_refinement);
  const SizeGrid sizes =
      context.phase("sizes", [&] { return SizeGrid(image, domain, options, coarsest_mm, object_voxels); });
  report.levels_given_up = sizes.levels_given_up();
  bcc::Lattice lattice = context.phase("refinement", [&] { return refined_lattice(frame, domain, sizes); });
  report.lattice_tetrahedra = lattice.size();
  BuiltLattice built;
  built.mesh = context.phase("labels", [&] { return make_work_mesh(std::move(lattice), frame, domain); });
  const BoundaryChoice choice =
      context.phase("boundary", [&] { return choose_boundary(built.mesh, domain); });
  report.relabelled = choice.relabelled;
  report.non_manifold_vertices = choice.non_manifold_vertices;
  context.phase("model", [&] {
    built.boundary = find_boundary(built.mesh, domain);
    std::vector<std::uint8_t> keep(built.mesh.tets.size());
    parallel::for_each_index(
        keep.size(), [&](std::size_t t) { keep[t] = domain.is_meshed(built.mesh.materials[t]) ? 1 : 0; });
    drop_tetrahedra(built.mesh, built.boundary, keep);
  });
  return built;
}

std::vector<Label> lost_labels(const WorkMesh& mesh, const ImageDomain& domain,
                               const std::vector<double>& voxels) {
  std::vector<std::uint8_t> seen(voxels.size(), 0);
  for (const Material m : mesh.materials) seen[m] = 1;
  std::vector<Label> lost;
  for (Material m = 1; m < voxels.size(); ++m) {
    if (seen[m] == 0 && voxels[m] > 0) lost.push_back(domain.label_of(m));
  }
  return lost;
}

/// Asks for a finer lattice around lost labels; false if there is nothing to gain.
bool raise_fidelity(LatticeOptions& options, const std::vector<Label>& lost) {
  constexpr double kHigh = 0.9;
  bool raised = false;
  for (const Label label : lost) {
    double& fidelity = options.label_fidelity.try_emplace(label, options.fidelity).first->second;
    if (fidelity >= 0.97) continue;
    fidelity = fidelity < kHigh ? kHigh : 0.97;
    raised = true;
  }
  return raised;
}

void note_lost(const std::vector<Label>& lost, const ImageDomain& domain, const std::vector<double>& voxels,
               LatticeReport& report) {
  for (Material m = 1; m < voxels.size(); ++m) {
    const Label label = domain.label_of(m);
    if (std::find(lost.begin(), lost.end(), label) == lost.end()) continue;
    report.notes.push_back("label " + std::to_string(label) + " (" + std::to_string(std::lround(voxels[m])) +
                           " voxels) is too small for the lattice and is lost");
    report.lost_labels.push_back(label);
  }
}

std::string decimals(double number, int count) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(count) << number;
  return text.str();
}

/// Notes for the user on a mesh that is less than perfect.
void note_shortcomings(const LatticeOptions& options, LatticeReport& report) {
  if (report.levels_given_up > 0)
    report.notes.push_back("thin parts are refined " + std::to_string(report.levels_given_up) +
                           " levels less than wanted, to stay near " +
                           std::to_string(options.max_tetrahedra) + " tetrahedra; raise `max_tetrahedra`");
  if (report.non_manifold_vertices > 0)
    report.notes.push_back("a label's boundary is not a manifold at " +
                           counted(report.non_manifold_vertices, "vertex", "vertices") +
                           "; try another `edge_length`");
  if (report.deviating_points > 0)
    report.notes.push_back(
        "the surface and the image's boundary are up to " + decimals(report.furthest_deviation_mm, 2) +
        " mm apart (" + std::to_string(report.deviating_points) + " points are off by more than 1.25 voxels" +
        "); a smaller `edge_length` or higher `fidelity` helps");
}

/// Labels that are too thin for the lattice fill another volume than their voxels.
void note_volumes(const WorkMesh& mesh, const ImageDomain& domain, const std::vector<double>& voxels,
                  LatticeReport& report) {
  constexpr double kMuch = 0.05;
  const std::vector<double> filled = material_volumes_mm3(mesh, voxels.size());
  std::size_t count = 0;
  double worst = 0;
  Label label = 0;
  for (Material m = 1; m < filled.size(); ++m) {
    const double wanted = voxels[m] * domain.frame().voxel_volume_mm3();
    const bool is_below_one_voxel = voxels[m] < 1;       // Grazed by a cut plane.
    if (filled[m] <= 0 || is_below_one_voxel) continue;  // Lost labels are reported by note_lost().
    const double change = filled[m] / wanted - 1;
    count += std::abs(change) > kMuch ? 1 : 0;
    if (std::abs(change) <= std::abs(worst)) continue;
    worst = change;
    label = domain.label_of(m);
  }
  if (count == 0) return;
  std::string note = "label " + std::to_string(label) + " fills " + decimals(100 * std::abs(worst), 1) +
                     (worst < 0 ? " % less" : " % more") + " than its voxels";
  if (count > 1) note += ", the worst of " + std::to_string(count) + " labels that are more than 5 % off";
  report.notes.push_back(note + "; a smaller `edge_length` or higher `fidelity` helps");
}

void finish_lattice(const LabelImage& image, BuiltLattice built, const ImageDomain& domain,
                    const LatticeOptions& options, const std::vector<double>& voxels, Context& context,
                    LatticeResult& result) {
  if (built.mesh.tets.empty())
    throw Error(
        ErrorKind::kBadInput,
        "the object is too small for the lattice; choose a smaller `edge_length` or a higher `fidelity`");
  const FitOptions fit_options{options.min_dihedral_deg, options.max_dihedral_deg,
                               context.phase("probes", [&] { return boundary_probes(image, domain); })};
  const FitReport fit = context.phase(
      "fit", [&] { return fit_to_domain(built.mesh, built.boundary, image, domain, fit_options); });
  result.report.deviating_points = fit.deviating_points;
  result.report.furthest_deviation_mm = fit.furthest_deviation_mm;
  if (fit.vertices_beyond > 0)
    result.report.notes.push_back(
        counted(fit.vertices_beyond, "vertex lies", "vertices lie") + " up to " +
        decimals(fit.furthest_beyond_mm, 3) +
        " mm beyond the image's border or a cut plane; another `edge_length` helps");
  note_shortcomings(options, result.report);
  note_volumes(built.mesh, domain, voxels, result.report);
  result.mesh = to_mixed_mesh(built.mesh, built.boundary, domain);
  if (options.mixed)
    context.phase("hexahedra", [&] { merge_hexahedra(result.mesh, domain.frame().direction); });
}

}  // namespace

LatticeResult mesh_lattice(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                           Context& context) {
  options.validate();
  options.require_labels_of(image);
  const std::vector<double> voxels =
      context.phase("count", [&] { return count_kept_voxels(image, domain.cut_planes()); });
  const auto object_voxels =
      static_cast<std::size_t>(std::ceil(std::accumulate(voxels.begin(), voxels.end(), 0.0)));
  if (object_voxels == 0)
    throw Error(ErrorKind::kBadInput,
                "nothing is left of the object: no voxel has a label on the kept side of the cut planes");
  LatticeOptions trial = options;
  LatticeResult result;
  for (int attempt = 0;; ++attempt) {
    BuiltLattice built = build_lattice(image, domain, trial, object_voxels, context, result.report);
    const std::vector<Label> lost = lost_labels(built.mesh, domain, voxels);
    if (attempt == kMaxRescues || !raise_fidelity(trial, lost)) {
      note_lost(lost, domain, voxels, result.report);
      finish_lattice(image, std::move(built), domain, trial, voxels, context, result);
      return result;
    }
  }
}

}  // namespace lumesh
