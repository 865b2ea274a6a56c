#pragma once
/// @file How far triangle surfaces are from each other.

#include <functional>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::surfaces {

/// Calls visit(point) for the centres of the n^2 equal parts of a triangle.
template <class Visit>
void for_each_part_centre(const Vec3& a, const Vec3& b, const Vec3& c, int n, const Visit& visit) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      visit(Vec3(a + (b - a) * ((i + 1.0 / 3) / n) + (c - a) * ((j + 1.0 / 3) / n)));
      if (i + j + 1 < n) visit(Vec3(a + (b - a) * ((i + 2.0 / 3) / n) + (c - a) * ((j + 2.0 / 3) / n)));
    }
}

/// The largest distance of points of some triangles to a surface: corners and centres of their equal parts
/// with no edge above `step_mm`, n^2 of each triangle with n a power of two, at most 64. One side of the
/// Hausdorff distance. Cost: little where no place can be farther than those found.
/// @param is_wanted  Whether a triangle counts; null: all. @param left_out_within  Below zero where a point
/// of one counts, else a radius around it within which no point of the triangle does; asked of points farther
/// than those before; null: all count. Threads: parallel inside, bitwise the same for every count.
[[nodiscard]] FarthestPoint farthest_from(
    const TriangleMesh& surface, const TriangleTree& other, double step_mm,
    const std::function<bool(std::size_t triangle)>& is_wanted = nullptr,
    const std::function<double(const Vec3& point, std::size_t triangle)>& left_out_within = nullptr);

}  // namespace lumesh::surfaces
