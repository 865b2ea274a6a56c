#include "coverage.hpp"

#include <algorithm>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh::layers {
namespace {

constexpr double kComplete = 0.98;  // Of the height wanted.

/// Places of the lowest columns, none within the length wanted there of another.
std::vector<LayerCoverage::Place> worst_places(const LayerSurface& surface, const Columns& columns,
                                               std::vector<std::uint32_t> vertices) {
  constexpr std::size_t kMax = 5;
  std::erase_if(vertices, [&](std::uint32_t v) { return columns.fraction[v] >= kComplete; });
  std::stable_sort(vertices.begin(), vertices.end(), [&](std::uint32_t a, std::uint32_t b) {
    return columns.fraction[a] < columns.fraction[b];
  });
  std::vector<LayerCoverage::Place> worst;
  for (const std::uint32_t v : vertices) {
    if (worst.size() == kMax) break;
    const Vec3& at = surface.points[v];
    const double apart = 2 * columns.wanted_mm[v];
    if (std::none_of(worst.begin(), worst.end(),
                     [&](const LayerCoverage::Place& place) { return (place.at - at).norm() < apart; }))
      worst.push_back({at, columns.fraction[v], columns.limit[v]});
  }
  return worst;
}

/// Each column counts by the thirds of the triangles around it.
LayerCoverage coverage_of_patch(const LayerSurface& surface, const Directions& directions,
                                const Columns& columns, std::int32_t patch) {
  LayerCoverage c;
  c.min_mm = std::numeric_limits<double>::infinity();
  std::vector<std::uint32_t> vertices;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (surface.patches[t] != patch) continue;
    const Cell<3>& corners = surface.triangles[t];
    const double third =
        triangle_area(surface.points[corners[0]], surface.points[corners[1]], surface.points[corners[2]]) / 3;
    for (const std::uint32_t v : corners) {
      vertices.push_back(v);
      c.area_mm2 += third;
      const double wanted = columns.wanted_mm[v] / directions.stretch[v];  // Across the surface.
      c.wanted_mm += third * wanted;
      c.achieved_mm += third * columns.fraction[v] * wanted;
      c.min_mm = std::min(c.min_mm, columns.fraction[v] * wanted);
      c.complete += columns.fraction[v] >= kComplete ? third : 0;
      c.unlayered += columns.fraction[v] == 0 ? third : 0;
      if (columns.fraction[v] < kComplete) c.limited[static_cast<std::size_t>(columns.limit[v])] += third;
    }
  }
  for (double* share : {&c.wanted_mm, &c.achieved_mm, &c.complete, &c.unlayered}) *share /= c.area_mm2;
  for (double& share : c.limited) share /= c.area_mm2;
  c.layered = 1 - c.unlayered;
  sort_unique(vertices);
  c.worst = worst_places(surface, columns, std::move(vertices));
  return c;
}

}  // namespace

std::vector<LayerCoverage> coverage_of(const TetMesh& mesh, const LayerSurface& surface,
                                       const Directions& directions, const Columns& columns, int layers) {
  std::vector<std::int32_t> patches = surface.patches;
  sort_unique(patches);
  std::vector<LayerCoverage> all;
  for (const std::int32_t patch : patches) {
    all.push_back(coverage_of_patch(surface, directions, columns, patch));
    all.back().layers = layers;
    all.back().patch = mesh.info().patches[static_cast<std::size_t>(patch)].name;
  }
  return all;
}

LayerShares shares_on(const LayerSurface& surface, const Columns& columns, bool is_inward) {
  LayerShares shares{surface.points, surface.triangles, columns.fraction};
  if (is_inward)
    for (Cell<3>& c : shares.triangles) std::swap(c[1], c[2]);
  return shares;
}

}  // namespace lumesh::layers
