#include "widest_section.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lumesh::report {

namespace {

constexpr std::size_t kMaxCells = 200000;
constexpr std::size_t kSlabs = 96;       // Across the diagonal of the mesh.
constexpr std::size_t kFinerSlabs = 24;  // Across the slab that is chosen and half of each neighbour.

/// A cell as a point with a weight that grows like its volume, which is good enough to choose a place.
struct CellPoint {
  Vec3 middle;
  double weight;
};

std::vector<CellPoint> some_cells(const MeshView& mesh) {
  const std::size_t stride = 1 + mesh.cell_count() / kMaxCells;
  std::vector<CellPoint> cells;
  const auto add = [&](const auto& all) {
    for (std::size_t i = 0; i < all.size(); i += stride) {
      Box3 box;
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t v : all[i]) {
        box.extend(mesh.points[v]);
        sum += mesh.points[v];
      }
      cells.push_back({sum / static_cast<double>(all[i].size()), box.volume()});
    }
  };
  add(mesh.tetrahedra);
  add(mesh.pyramids);
  add(mesh.prisms);
  add(mesh.hexahedra);
  return cells;
}

/// The fullest of equal slabs across a normal.
struct Slab {
  double offset_mm = 0;  ///< Of its middle.
  double weight = 0;
};

Slab fullest_slab(const std::vector<CellPoint>& cells, const Vec3& normal, double low_mm, double thickness_mm,
                  std::size_t count) {
  std::vector<double> weights(count + 2, 0);  // With an empty one beyond each end.
  for (const CellPoint& cell : cells) {
    const double at = (normal.dot(cell.middle) - low_mm) / thickness_mm;
    if (at >= 0 && at < static_cast<double>(count)) weights[static_cast<std::size_t>(at) + 1] += cell.weight;
  }
  Slab best = {low_mm, -1};
  for (std::size_t i = 0; i < count; ++i) {
    const double smooth = weights[i] / 2 + weights[i + 1] + weights[i + 2] / 2;
    if (smooth > best.weight) best = {low_mm + (static_cast<double>(i) + 0.5) * thickness_mm, smooth};
  }
  return best;
}

}  // namespace

SectionView widest_section(const MeshView& mesh, const ViewAngles& angles, const Vec3& apart_from) {
  constexpr double kAlike = 0.7072;  // Cosine of a bit less than 45 degrees.
  const std::vector<CellPoint> cells = some_cells(mesh);
  Box3 box;
  for (const CellPoint& cell : cells) box.extend(cell.middle);
  const Vec3 centre = box.center();
  const double reach_mm = std::max(box.diagonal().norm() / 2, 1e-9) * 1.001,
               thickness_mm = 2 * reach_mm / kSlabs;
  SectionView best;
  double best_score = -1;
  for (const double turn : {0.0, -20.0, 20.0, -40.0, 40.0})
    for (const double rise : {0.0, -20.0, 20.0, -40.0, 40.0}) {
      if (std::hypot(turn, rise) > 41 || std::abs(angles.elevation_deg + rise) > 85) continue;
      const ViewAngles tried = {angles.azimuth_deg + turn, angles.elevation_deg + rise};
      const Vec3 normal = look_from(tried.azimuth_deg, tried.elevation_deg).toward;
      const bool straight_ahead = turn == 0 && rise == 0;  // Stays whatever it is apart from.
      if (!straight_ahead && std::abs(normal.dot(apart_from)) > kAlike) continue;
      const Slab slab = fullest_slab(cells, normal, normal.dot(centre) - reach_mm, thickness_mm, kSlabs);
      const double score = slab.weight * (1 - std::hypot(turn, rise) / 400);  // Rather straight ahead.
      if (score <= best_score) continue;
      best_score = score;
      best = {{slab.offset_mm * normal, normal}, tried};
    }
  const Vec3& normal = best.plane.normal;
  const double finer_mm = 2 * thickness_mm / kFinerSlabs;
  const Slab finer =
      fullest_slab(cells, normal, normal.dot(best.plane.point_mm) - thickness_mm, finer_mm, kFinerSlabs);
  // A little off the slab's middle: planes of a lattice would give flat slivers of sections.
  best.plane.point_mm = (finer.offset_mm + 0.0137 * finer_mm) * normal;
  return best;
}

}  // namespace lumesh::report
