#pragma once
/// @file Exact geometric predicates: the sign returned is that of the exact real value for the given doubles.
///
/// A floating-point filter decides almost every call inline; what it cannot decide goes to CGAL's kernel
/// (LGPL part). All coordinates must be finite. Threads: pure functions. Cost: about 10 ns (orient3d), 25 ns
/// (insphere) when the filter decides, about 0.5 us otherwise.

#include <Eigen/Core>
#include <cmath>

#include "lumesh/core/types.hpp"

namespace lumesh {

using Vec2 = Eigen::Vector2d;

namespace detail {
int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c);
int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
int insphere_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e);

inline constexpr double kRoundoff = 0x1p-53;
// Outside these bounds of the coordinate differences, under- or overflow could spoil the filters.
inline constexpr double kFilterSmallest = 1e-40;
inline constexpr double kFilterLargest = 1e+40;

// By value, so that each is one instruction; std::max returns references, which end up as branches.
inline double smaller(double x, double y) {
  return x < y ? x : y;
}
inline double larger(double x, double y) {
  return x > y ? x : y;
}

/// Largest magnitude of one coordinate of three vectors.
inline double largest(double x, double y, double z) {
  return larger(larger(std::abs(x), std::abs(y)), std::abs(z));
}
inline bool in_filter_range(double x, double y, double z) {
  return smaller(smaller(x, y), z) > kFilterSmallest && larger(larger(x, y), z) < kFilterLargest;
}
}  // namespace detail

/// Sign of the area of triangle (a, b, c): +1 anticlockwise, -1 clockwise, 0 on one line.
[[nodiscard]] inline int orient2d(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  const double left = u.x() * v.y(), right = u.y() * v.x();
  const double determinant = left - right;
  const double magnitude = std::abs(left) + std::abs(right);
  // Shewchuk 1997, doi:10.1007/PL00009321: (3 + 16 eps) eps; 4 eps covers it and the lost denormals.
  if (magnitude > detail::kFilterSmallest && magnitude < detail::kFilterLargest &&
      std::abs(determinant) > 4 * detail::kRoundoff * magnitude)
    return determinant > 0 ? 1 : -1;
  return detail::orient2d_exact(a, b, c);
}

/// Sign of ((b-a) x (c-a)) . (d-a): +1 for a positively oriented tetrahedron (VTK order), 0 if coplanar.
/// An even permutation of the arguments keeps the sign, an odd one flips it.
[[nodiscard]] inline int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double max_x = detail::largest(u.x(), v.x(), w.x());
  const double max_y = detail::largest(u.y(), v.y(), w.y());
  const double max_z = detail::largest(u.z(), v.z(), w.z());
  if (max_x == 0 || max_y == 0 || max_z == 0)
    return 0;  // A difference of doubles is zero only if they are equal.
  if (detail::in_filter_range(max_x, max_y, max_z)) {
    const double determinant = u.x() * (v.y() * w.z() - v.z() * w.y()) +
                               v.x() * (w.y() * u.z() - w.z() * u.y()) +
                               w.x() * (u.y() * v.z() - u.z() * v.y());
    // Shewchuk 1997: error <= (7 + 56 eps) eps * permanent, and the permanent is <= 6 max_x max_y max_z.
    const double bound = 48 * detail::kRoundoff * max_x * max_y * max_z;
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  return detail::orient3d_exact(a, b, c, d);
}

/// +1 if `e` lies inside the sphere through a positively oriented (a, b, c, d), -1 outside, 0 on it; the sign
/// flips if (a, b, c, d) is negatively oriented. Antisymmetric in all five arguments like orient3d in its
/// four.
[[nodiscard]] inline int insphere(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  const Vec3 p = a - e, q = b - e, r = c - e, s = d - e;
  const double max_x = detail::larger(detail::largest(p.x(), q.x(), r.x()), std::abs(s.x()));
  const double max_y = detail::larger(detail::largest(p.y(), q.y(), r.y()), std::abs(s.y()));
  const double max_z = detail::larger(detail::largest(p.z(), q.z(), r.z()), std::abs(s.z()));
  if (detail::in_filter_range(max_x, max_y, max_z)) {
    const double pq = p.x() * q.y() - q.x() * p.y(), qr = q.x() * r.y() - r.x() * q.y();
    const double rs = r.x() * s.y() - s.x() * r.y(), sp = s.x() * p.y() - p.x() * s.y();
    const double pr = p.x() * r.y() - r.x() * p.y(), qs = q.x() * s.y() - s.x() * q.y();
    const double pqr = p.z() * qr - q.z() * pr + r.z() * pq;
    const double qrs = q.z() * rs - r.z() * qs + s.z() * qr;
    const double rsp = r.z() * sp + s.z() * pr + p.z() * rs;
    const double spq = s.z() * pq + p.z() * qs + q.z() * sp;
    const double determinant =
        (r.squaredNorm() * spq - s.squaredNorm() * pqr) + (p.squaredNorm() * qrs - q.squaredNorm() * rsp);
    // Shewchuk 1997: error <= (16 + 224 eps) eps * permanent; the permanent has 24 triple products, each
    // <= max_x max_y max_z, each times a squared length <= max_x^2 + max_y^2 + max_z^2.
    const double squared_length = max_x * max_x + max_y * max_y + max_z * max_z;
    const double bound = 17 * 24 * detail::kRoundoff * max_x * max_y * max_z * squared_length;
    // Terms in the order opposite to his, because his positive orientation is our negative one.
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  return detail::insphere_exact(a, b, c, d, e);
}

}  // namespace lumesh
