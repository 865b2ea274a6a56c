#include "lumesh/domain/usual_edge.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/geometry/hilbert.hpp"

namespace lumesh {

namespace {

/// Without components that are less than a tenth as long as the longest, such as specks, which may have more
/// triangles than the vessel.
std::vector<Cell<3>> of_large_components(std::span<const Vec3> points_mm,
                                         std::span<const Cell<3>> triangles) {
  constexpr double kLeastLength = 0.1;
  DisjointSets components(points_mm.size());
  for (const Cell<3>& t : triangles) {
    components.merge(t[0], t[1]);
    components.merge(t[1], t[2]);
  }
  std::vector<Box3> boxes(points_mm.size());
  for (const Cell<3>& t : triangles)
    for (const std::uint32_t v : t) boxes[components.find(t[0])].extend(points_mm[v]);
  double longest_mm = 0;
  for (const Box3& box : boxes)
    if (!box.isEmpty()) longest_mm = std::max(longest_mm, box.diagonal().norm());
  std::vector<Cell<3>> large;
  for (const Cell<3>& t : triangles)
    if (boxes[components.find(t[0])].diagonal().norm() >= kLeastLength * longest_mm) large.push_back(t);
  return large;
}

}  // namespace

double mean_edge_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles) {
  double sum = 0;
  for (const Cell<3>& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) sum += (points_mm[t[(i + 1) % 3]] - points_mm[t[i]]).norm();
  return sum / static_cast<double>(3 * triangles.size());
}

double usual_resolution_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles) {
  return std::min(kResolutionPerEdge * mean_edge_mm(points_mm, of_large_components(points_mm, triangles)),
                  bounding_box(points_mm).diagonal().norm() / kResolutionsPerDiagonal);
}

}  // namespace lumesh
