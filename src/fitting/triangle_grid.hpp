#pragma once
// A few triangles that can be found by place while more are added, and whether triangles cut each other.

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cube_keys.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/fitting/work_mesh.hpp"
#include "lumesh/geometry/tetrahedron.hpp"

namespace lumesh::fitting {

/// Whether a segment passes through a triangle.
[[nodiscard]] inline bool crosses(const Vec3& p, const Vec3& q, const TriangleCorners& t) {
  const auto side = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return tetrahedron_volume(a, b, c, d);
  };
  if (side(t[0], t[1], t[2], p) * side(t[0], t[1], t[2], q) >= 0) return false;
  const double u = side(p, q, t[0], t[1]), v = side(p, q, t[1], t[2]), w = side(p, q, t[2], t[0]);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

/// Triangles by the cells of a grid that their boxes touch.
class TriangleGrid {
 public:
  explicit TriangleGrid(double cell_mm) : cell_mm_(cell_mm) {}
  void add(const Triangle& t, const Box3& box) {
    for_each_cell(box, [&](std::uint64_t cell) { cells_[cell].push_back(t); });
  }
  /// Whether `condition` holds for a triangle in one of the cells of a box.
  template <class Condition>
  [[nodiscard]] bool any(const Box3& box, const Condition& condition) const {
    bool found = false;
    for_each_cell(box, [&](std::uint64_t cell) {
      const auto at = cells_.find(cell);
      if (!found && at != cells_.end()) found = std::ranges::any_of(at->second, condition);
    });
    return found;
  }

 private:
  template <class Body>
  void for_each_cell(const Box3& box, const Body& body) const {
    for_each_place(cube_of(box.min(), cell_mm_), cube_of(box.max(), cell_mm_),
                   [&](const Index3& cell) { body(cube_key(cell)); });
  }
  double cell_mm_;
  std::unordered_map<std::uint64_t, std::vector<Triangle>> cells_;
};

}  // namespace lumesh::fitting
