#pragma once
/// @file Measures of one triangle and its nearest point. Pure inline functions.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Normal of triangle (a, b, c) by the right-hand rule; its length is twice the area.
[[nodiscard]] inline Vec3 triangle_area_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a);
}

/// Normal of a triangle of a surface by the numbers of its corners.
[[nodiscard]] inline Vec3 triangle_area_normal(std::span<const Vec3> points,
                                               const std::array<std::uint32_t, 3>& corners) {
  return triangle_area_normal(points[corners[0]], points[corners[1]], points[corners[2]]);
}

/// Area in the square of the coordinates' unit, >= 0.
[[nodiscard]] inline double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * triangle_area_normal(a, b, c).norm();
}
[[nodiscard]] inline double triangle_area(std::span<const Vec3> points,
                                          const std::array<std::uint32_t, 3>& corners) {
  return triangle_area(points[corners[0]], points[corners[1]], points[corners[2]]);
}

/// Mean of the corners.
[[nodiscard]] inline Vec3 triangle_centre(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (a + b + c) / 3;
}
[[nodiscard]] inline Vec3 triangle_centre(std::span<const Vec3> points,
                                          const std::array<std::uint32_t, 3>& corners) {
  return triangle_centre(points[corners[0]], points[corners[1]], points[corners[2]]);
}

/// In [0, pi]; accurate for small angles too.
[[nodiscard]] inline double angle_between(const Vec3& u, const Vec3& v) {
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Radius of the circle of an area, in the root of its unit.
[[nodiscard]] inline double circle_radius(double area) {
  return std::sqrt(area / std::numbers::pi);
}

/// What flat faces have together, added in the order in which they come.
struct AreaSum {
  double area = 0;
  Vec3 normal = Vec3::Zero();  ///< Sum of normals as long as the areas.
  Vec3 moment = Vec3::Zero();  ///< Sum of centres times areas.

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 own = 0.5 * triangle_area_normal(a, b, c);
    const double size = own.norm();
    area += size;
    normal += own;
    moment += size / 3 * (a + b + c);
  }
  /// @param area_normal  As long as the area of the face.
  void add(const Vec3& area_normal, const Vec3& face_centre) {
    const double size = area_normal.norm();
    area += size;
    normal += area_normal;
    moment += size * face_centre;
  }
  /// Not a number where there is no area.
  [[nodiscard]] Vec3 centre() const { return moment / area; }
};

/// Unit normal by the right-hand rule; zero for a triangle without area.
[[nodiscard]] inline Vec3 triangle_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = triangle_area_normal(a, b, c);
  const double length = normal.norm();
  return length > 0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
}
[[nodiscard]] inline Vec3 triangle_normal(std::span<const Vec3> points,
                                          const std::array<std::uint32_t, 3>& corners) {
  return triangle_normal(points[corners[0]], points[corners[1]], points[corners[2]]);
}

/// Cosine of the angle opposite the shortest side. Not a number if two corners are in one place.
[[nodiscard]] inline double cosine_of_smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double least = std::min({ab, bc, ca});
  return (ab + bc + ca - 2 * least) / (2 * std::sqrt(ab * bc * ca / least));
}

/// How far from `a` to `b` the nearest point of segment (a, b) to `p` lies, in [0, 1]; 0 if the segment has
/// no length.
template <int N>
[[nodiscard]] double share_along_segment(const Eigen::Matrix<double, N, 1>& p,
                                         const Eigen::Matrix<double, N, 1>& a,
                                         const Eigen::Matrix<double, N, 1>& b) {
  const Eigen::Matrix<double, N, 1> direction = b - a;
  const double squared_length = direction.squaredNorm();
  return squared_length > 0 ? std::clamp(direction.dot(p - a) / squared_length, 0.0, 1.0) : 0;
}

/// Nearest point of segment (a, b) to `p`; a segment of length zero is its point.
[[nodiscard]] inline Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = share_along_segment(p, a, b);
  return t <= 0 ? a : t >= 1 ? b : Vec3(a + t * (b - a));
}

/// Nearest point of triangle (a, b, c) to `p`; a triangle without area is its edges.
/// Source: Ericson 2005, Real-Time Collision Detection, section 5.1.5.
[[nodiscard]] inline Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                                    const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return closest_point_on_segment(p, a, b);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return closest_point_on_segment(p, a, c);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && (d4 - d3) >= 0 && (d5 - d6) >= 0) return closest_point_on_segment(p, b, c);
  const double scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

}  // namespace lumesh
