#pragma once
/// @file Sections of cells with a plane.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/quality/hausdorff.hpp"
#include "lumesh/quality/statistics.hpp"

namespace lumesh::report {

/// Mean ratio of a tetrahedron, scaled Jacobian of another cell.
[[nodiscard]] inline double cell_quality(std::span<const Vec3> points, const Cell<4>& v) {
  return mean_ratio(points[v[0]], points[v[1]], points[v[2]], points[v[3]]);
}
template <std::size_t N>
[[nodiscard]] double cell_quality(std::span<const Vec3> points, const Cell<N>& cell) {
  return quality::scaled_jacobian(points, cell);
}

/// The convex section of a cell with a plane, in order around its middle; empty if the plane misses the cell.
template <std::size_t N, std::size_t Edges>
[[nodiscard]] std::vector<Vec3> cut_cell(std::span<const Vec3> points, const Cell<N>& cell,
                                         const std::array<std::array<int, 2>, Edges>& edges,
                                         const CutPlane& plane) {
  std::array<double, N> height;
  bool above = false, below = false;
  for (std::size_t i = 0; i < N; ++i) {
    height[i] = plane.normal.dot(points[cell[i]] - plane.point_mm);
    (height[i] > 0 ? above : below) = true;
  }
  std::vector<Vec3> section;
  if (!above || !below) return section;
  for (const auto& [i, j] : edges)
    if ((height[i] > 0) != (height[j] > 0))
      section.push_back(points[cell[i]] +
                        (points[cell[j]] - points[cell[i]]) * (height[i] / (height[i] - height[j])));
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : section) middle += p / static_cast<double>(section.size());
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  std::ranges::sort(section, [&](const Vec3& a, const Vec3& b) {
    return std::atan2(v.dot(a - middle), u.dot(a - middle)) <
           std::atan2(v.dot(b - middle), u.dot(b - middle));
  });
  return section;
}

}  // namespace lumesh::report
