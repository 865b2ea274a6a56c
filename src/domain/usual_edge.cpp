#include "lumesh/domain/usual_edge.hpp"

#include <algorithm>

#include "lumesh/geometry/hilbert.hpp"

namespace lumesh {

double mean_edge_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles) {
  double sum = 0;
  for (const Cell<3>& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) sum += (points_mm[t[(i + 1) % 3]] - points_mm[t[i]]).norm();
  return sum / static_cast<double>(3 * triangles.size());
}

double usual_resolution_mm(std::span<const Vec3> points_mm, std::span<const Cell<3>> triangles) {
  return std::min(kResolutionPerEdge * mean_edge_mm(points_mm, triangles),
                  bounding_box(points_mm).diagonal().norm() / kResolutionsPerDiagonal);
}

}  // namespace lumesh
