#pragma once
/// @file The plane of a triangle, seen along the axis along which the triangle is largest.

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <utility>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {

/// Two of the coordinates of points, in which a triangle runs anticlockwise: signs of areas of its plane
/// stay. Any two will do in which it does not become a line, those in which it is largest spare exact
/// arithmetic.
class PlaneView {
 public:
  /// @param a, b, c  Finite corners of the triangle.
  PlaneView(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = triangle_area_normal(a, b, c).cwiseAbs();
    std::array<int, 3> axes = {0, 1, 2};  // By falling area, the lower one first of equal ones.
    const auto put_in_order = [&](std::size_t at) {
      if (normal[axes[at]] > normal[axes[at - 1]]) std::swap(axes[at], axes[at - 1]);
    };
    put_in_order(1);
    put_in_order(2);
    put_in_order(1);
    for (const int axis : axes) {
      x_ = (axis + 1) % 3;
      y_ = (axis + 2) % 3;
      const int turn = orient2d(seen(a), seen(b), seen(c));
      if (turn < 0) std::swap(x_, y_);
      has_area_ = turn != 0;
      if (has_area_) return;
    }
  }
  explicit PlaneView(const std::array<Vec3, 3>& corners) : PlaneView(corners[0], corners[1], corners[2]) {}

  /// False for a triangle without an area, of which nothing is to be seen: exactly.
  [[nodiscard]] bool has_area() const { return has_area_; }
  [[nodiscard]] Vec2 seen(const Vec3& point) const { return {point[x_], point[y_]}; }
  /// Whether a point of the plane lies to the left of (a, b), 0 on it: exactly.
  [[nodiscard]] int left_of(const Vec3& a, const Vec3& b, const Vec3& point) const {
    return orient2d(seen(a), seen(b), seen(point));
  }

 private:
  int x_ = 0, y_ = 1;
  bool has_area_ = false;
};

}  // namespace lumesh
