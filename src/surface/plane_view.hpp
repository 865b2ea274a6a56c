#pragma once
// The plane of a triangle, in which it runs anticlockwise.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh::surfaces {

/// Two of the coordinates of points, those in which a triangle is largest: signs of areas of its plane stay.
class PlaneView {
 public:
  /// @param a, b, c  Corners of a triangle that has an area.
  PlaneView(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = triangle_area_normal(a, b, c).cwiseAbs();
    std::array<std::size_t, 3> axes = {0, 1, 2};
    std::ranges::sort(axes, [&](std::size_t i, std::size_t k) {
      return std::pair(-normal[static_cast<int>(i)], i) < std::pair(-normal[static_cast<int>(k)], k);
    });
    for (const std::size_t axis : axes) {
      x_ = static_cast<int>((axis + 1) % 3);
      y_ = static_cast<int>((axis + 2) % 3);
      const int turn = orient2d(seen(a), seen(b), seen(c));
      if (turn < 0) std::swap(x_, y_);
      if (turn != 0) return;
    }
  }
  [[nodiscard]] Vec2 seen(const Vec3& point) const { return {point[x_], point[y_]}; }
  /// Exactly, for points of the plane.
  [[nodiscard]] int left_of(const Vec3& a, const Vec3& b, const Vec3& point) const {
    return orient2d(seen(a), seen(b), seen(point));
  }

 private:
  int x_ = 0, y_ = 1;
};

}  // namespace lumesh::surfaces
