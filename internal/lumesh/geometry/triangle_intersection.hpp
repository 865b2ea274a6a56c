#pragma once
/// @file Whether two triangles in space have a point in common, by exact predicates.

#include <array>

#include "lumesh/geometry/predicates.hpp"

namespace lumesh {

/// Whether the closed segment (p, q) and the closed triangle (a, b, c) meet, not if they lie in one plane,
/// where the sides of the triangle's plane on which the ends lie, orient3d(a, b, c, p) and orient3d(a, b, c,
/// q), are known.
[[nodiscard]] inline bool segment_meets_triangle(const Vec3& p, const Vec3& q, int at_p, int at_q,
                                                 const Vec3& a, const Vec3& b, const Vec3& c) {
  if (at_p * at_q > 0 || (at_p == 0 && at_q == 0)) return false;
  const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c), ca = orient3d(p, q, c, a);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

/// Whether the closed segment (p, q) and the closed triangle (a, b, c) meet; not if they lie in one plane.
[[nodiscard]] inline bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b,
                                                 const Vec3& c) {
  return segment_meets_triangle(p, q, orient3d(a, b, c, p), orient3d(a, b, c, q), a, b, c);
}

/// Whether two closed triangles meet; not if they lie in one plane.
[[nodiscard]] inline bool triangles_meet(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (segment_meets_triangle(a[k], a[(k + 1) % 3], b[0], b[1], b[2]) ||
        segment_meets_triangle(b[k], b[(k + 1) % 3], a[0], a[1], a[2]))
      return true;
  return false;
}

}  // namespace lumesh
