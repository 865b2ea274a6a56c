#include "lumesh/lattice/lattice.hpp"

#include <cmath>

#include "boundary_choice.hpp"
#include "fit.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "patches.hpp"
#include "refinement.hpp"
#include "size_grid.hpp"
#include "work_mesh.hpp"

namespace lumesh {

namespace {

constexpr double kDefaultSpacingVoxels = 3;

MixedMesh to_mixed_mesh(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain) {
  MixedMesh out;
  out.points = std::move(mesh.positions);
  out.tetrahedra = std::move(mesh.tets);
  out.tetrahedron_labels.resize(out.tetrahedra.size());
  parallel::for_each_index(out.tetrahedra.size(),
                           [&](std::size_t t) { out.tetrahedron_labels[t] = domain.label_of(mesh.materials[t]); });
  PatchAssignment patches = name_patches(boundary, out.points, domain);
  out.info.patches = std::move(patches.patches);
  out.triangle_patches = std::move(patches.of_triangle);
  out.triangles.resize(boundary.triangles.size());
  parallel::for_each_index(out.triangles.size(), [&](std::size_t t) { out.triangles[t] = boundary.triangles[t].vertices; });
  return out;
}

}  // namespace

void LatticeOptions::validate() const {
  const auto check = [](bool good, const char* message) {
    if (!good) throw Error(ErrorKind::kUsage, message);
  };
  check(std::isfinite(spacing_mm) && spacing_mm >= 0, "the lattice spacing must be a positive number of mm");
  check(fidelity >= 0.1 && fidelity <= 0.98, "the fidelity must lie in [0.1, 0.98]");
  for (const auto& [label, value] : label_fidelity)
    check(value >= 0.1 && value <= 0.98, "the fidelity of a label must lie in [0.1, 0.98]");
  check(coarsening >= 0 && coarsening <= 4, "the coarsening must lie in [0, 4]");
  check(max_refinement >= 0 && max_refinement <= 5, "the refinement limit must lie in [0, 5]");
  check(min_dihedral_deg >= 1 && min_dihedral_deg <= 25, "the smallest dihedral angle must lie in [1, 25] degrees");
  check(max_dihedral_deg >= 130 && max_dihedral_deg <= 175, "the largest dihedral angle must lie in [130, 175] degrees");
}

LatticeResult mesh_lattice(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                           Context& context) {
  options.validate();
  const double spacing_mm =
      options.spacing_mm > 0 ? options.spacing_mm : kDefaultSpacingVoxels * domain.voxel_size_mm();
  const double coarsest_mm = spacing_mm * std::exp2(options.coarsening);
  const LatticeFrame frame = make_lattice_frame(domain, coarsest_mm, options.coarsening + options.max_refinement);

  LatticeResult result;
  const SizeGrid sizes =
      context.phase("sizes", [&] { return SizeGrid(image, domain, options, coarsest_mm); });
  std::vector<bcc::Corners> lattice =
      context.phase("refinement", [&] { return refined_lattice(frame, domain, sizes); });
  result.report.lattice_tetrahedra = lattice.size();
  WorkMesh mesh = context.phase("labels", [&] { return make_work_mesh(std::move(lattice), frame, domain); });
  const BoundaryChoice choice = context.phase("boundary", [&] { return choose_boundary(mesh, domain); });
  result.report.relabelled = choice.relabelled;
  if (choice.non_manifold_vertices > 0) result.report.notes.push_back("non-manifold " + std::to_string(choice.non_manifold_vertices));
  BoundaryModel boundary = context.phase("model", [&] {
    BoundaryModel model = find_boundary(mesh, domain);
    std::vector<std::uint8_t> keep(mesh.tets.size());
    parallel::for_each_index(keep.size(),
                             [&](std::size_t t) { keep[t] = domain.is_meshed(mesh.materials[t]) ? 1 : 0; });
    drop_tetrahedra(mesh, model, keep);
    return model;
  });
  const FitReport fit = context.phase("fit", [&] {
    return fit_to_domain(mesh, boundary, domain, {options.min_dihedral_deg, options.max_dihedral_deg});
  });
  result.report.off_boundary_vertices = fit.off_boundary_vertices;
  result.report.largest_offset_voxels = fit.largest_offset_mm / domain.voxel_size_mm();
  result.mesh = to_mixed_mesh(mesh, boundary, domain);
  return result;
}

}  // namespace lumesh
