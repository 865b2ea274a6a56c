#include "lumesh/fitting/fit.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "crossings.hpp"
#include "defects.hpp"
#include "exposed_tetrahedra.hpp"
#include "fitter.hpp"
#include "folds.hpp"
#include "lumesh/mesh/small_pieces.hpp"
#include "opening_rims.hpp"
#include "sagittas.hpp"
#include "vertex_blocks.hpp"
#include "wall_settling.hpp"

namespace lumesh::fitting {

namespace {

/// Sweeps over the vertices near the boundary, and rounds of such, of each step: what is left after them are
/// single places, for which later steps look.
constexpr int kLatticeSweeps = 4, kApproachSweeps = 1, kProtrusionSweeps = 3, kFitSweeps = 2,
              kImproveSweeps = 4, kCutRounds = 3;

/// @param deviations    Those of outlier triangles count.
/// @param distances_mm  Distances of the deviating probes from the surface.
FitReport report_on(const std::vector<Deviation>& deviations, const std::vector<double>& distances_mm,
                    double voxel_mm) {
  constexpr double kFar =
      1.25;  // voxels; more than what defects are repaired to, so that few meshes are blamed
  FitReport report;
  const auto add = [&](double off_mm) {
    if (off_mm <= kFar * voxel_mm) return;
    ++report.deviating_points;
    report.furthest_deviation_mm = std::max(report.furthest_deviation_mm, off_mm);
  };
  for (const double distance_mm : distances_mm) add(distance_mm);
  for (const Deviation& deviation : deviations) {
    if (deviation.is_outlier) add(deviation.off_mm);
  }
  return report;
}

void add_beyond_cuts(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                     FitReport& report) {
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const double off_mm = beyond_cuts_mm(domain, boundary.sets[v], mesh.positions[v]);
    if (off_mm <= kLittleBeyond * domain.voxel_size_mm()) continue;
    ++report.vertices_beyond;
    report.furthest_beyond_mm = std::max(report.furthest_beyond_mm, off_mm);
  }
}

void flatten_openings(WorkMesh& mesh, BoundaryModel& boundary, const FitSetting& setting) {
  build_stars(mesh);
  VertexTargets none;
  const VertexBlocks all_stay;
  Fitter(mesh, boundary, none, setting, all_stay).flatten_openings();
}

/// Carries the boundary of the whole lattice roughly to its place and removes tetrahedra that are exposed
/// there.
/// @return Places in the lattice of the vertices that are left.
std::vector<Vec3> approach(WorkMesh& mesh, BoundaryModel& boundary, const FitSetting& setting,
                           VertexBlocks& blocks) {
  std::vector<Vec3> lattice_mm = mesh.positions;
  VertexTargets targets;
  Fitter(mesh, boundary, targets, setting, blocks).approach(kLatticeSweeps);
  choose_rims(mesh, boundary, setting.domain);
  const std::vector<std::uint32_t> kept = remove_exposed(mesh, boundary, setting.domain);
  keep_vertices(blocks, kept);
  for (std::size_t v = 0; v < kept.size(); ++v) lattice_mm[v] = lattice_mm[kept[v]];
  lattice_mm.resize(kept.size());
  mesh.neighbours = UninitialisedVector<Corner4>();  // Not needed any more.
  return lattice_mm;
}

/// Vertices of the boundary come to the surface, so that facets are neither within it nor beyond it in the
/// mean.
void fit_boundary(Fitter& fitter, DeviationFinder& finder, const WorkMesh& mesh,
                  const BoundaryModel& boundary, const ImageDomain& domain, VertexTargets& targets) {
  constexpr double kProtrusionVoxels = 1.1;  // probes further from the surface attract it
  fitter.approach(kApproachSweeps);
  fitter.attract_to_protrusions(
      finder.find_probe_deviations(mesh, boundary, kProtrusionVoxels * domain.voxel_size_mm()),
      kProtrusionSweeps);
  targets.offset_mm = fitter.averaged(sagitta_offsets_mm(mesh, boundary, domain));
  fitter.fit(kFitSweeps);
  fitter.fit_and_improve(kImproveSweeps, Fitter::kGood);
}

/// Drops pieces that have been broken off, with their boundary.
void drop_small_pieces(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain) {
  const std::vector<std::uint8_t> is_small = vertices_of_small_pieces(
      mesh.positions.size(), kSmallPiece * domain.frame().voxel_volume_mm3(),
      [&](const auto& visit) { std::ranges::for_each(mesh.tets, visit); },
      [&](std::uint32_t v) -> const Vec3& { return mesh.positions[v]; });
  if (is_small.empty()) return;
  std::erase_if(boundary.triangles,
                [&](const BoundaryTriangle& triangle) { return is_small[triangle.vertices[0]] != 0; });
  std::vector<std::uint8_t> keep(mesh.tets.size());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = is_small[mesh.tets[t][0]] != 0 ? 0 : 1;
  build_neighbours(mesh);
  drop_tetrahedra(mesh, boundary, keep);
}

}  // namespace

FitReport fit_to_domain(WorkMesh& mesh, BoundaryModel& boundary, const LabelImage& image,
                        const ImageDomain& domain, const FitOptions& options) {
  const FitSetting setting{image, domain, {options.min_dihedral_deg, options.max_dihedral_deg}};
  VertexBlocks blocks = make_vertex_blocks(mesh, vertices_near_boundary(mesh, boundary));
  std::vector<Vec3> lattice_mm = approach(mesh, boundary, setting, blocks);
  VertexTargets targets;
  Fitter fitter(mesh, boundary, targets, setting, blocks);
  DeviationFinder finder(domain, options.probes);
  fit_boundary(fitter, finder, mesh, boundary, domain, targets);
  undo_crossings(mesh, boundary, domain, lattice_mm, setting.limits);
  const auto without_crossing = [&](const auto& step) {
    const std::vector<Vec3> before_mm = mesh.positions;
    step();
    undo_crossings(mesh, boundary, domain, before_mm, setting.limits);
  };
  without_crossing([&] { fitter.bring_within_cuts(kCutRounds, kImproveSweeps, Fitter::kGood); });
  fitter.squeeze_within_cuts();

  WholeMesh whole{mesh, boundary, targets, std::move(lattice_mm), {}, {}};
  const std::vector<Deviation> deviations = repair_defects(whole, setting, finder, options.probes.size());
  remove_folds(mesh, boundary, setting);
  choose_rims(mesh, boundary, domain);  // Triangles that have come to lie in a cut plane.
  without_crossing([&] { settle_wall(mesh, boundary, domain, setting.limits); });
  flatten_openings(mesh, boundary, setting);
  FitReport report =
      report_on(deviations, finder.deviating_probe_distances_mm(mesh, boundary), domain.voxel_size_mm());
  remove_beyond_cuts(mesh, boundary, domain);
  drop_small_pieces(mesh, boundary, domain);
  add_beyond_cuts(mesh, boundary, domain, report);
  return report;
}

}  // namespace lumesh::fitting
