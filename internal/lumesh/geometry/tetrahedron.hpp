#pragma once
/// @file Measures of one tetrahedron (a, b, c, d) in VTK order: positive volume iff orient3d(a, b, c, d) > 0.
/// Pure inline functions for hot loops; signs near zero are those of floating point, not exact (see
/// predicates.hpp).

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Vertices of edge e. Opposite edges are e and 5 - e. The order of dihedral_angles_deg().
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Signed volume.
[[nodiscard]] inline double tetrahedron_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6;
}

/// Sum of the six squared edge lengths.
[[nodiscard]] inline double sum_of_squared_edges(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).squaredNorm() + (c - a).squaredNorm() + (d - a).squaredNorm() + (c - b).squaredNorm() +
         (d - b).squaredNorm() + (d - c).squaredNorm();
}

/// Mean ratio 12 (3V)^(2/3) / (sum of squared edges): 1 for the regular tetrahedron, 0 for a flat one,
/// negative for an inverted one; 0 if all points coincide. Source: Liu and Joe 1994, doi:10.1007/BF01955874;
/// the constant is checked in docs/stages/adapt.md, "Lengths and shapes".
[[nodiscard]] inline double mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double volume = tetrahedron_volume(a, b, c, d);
  const double edges = sum_of_squared_edges(a, b, c, d);
  if (!(edges > 0)) return 0;
  return std::copysign(12 * std::cbrt(9 * volume * volume) / edges, volume);
}

/// Cosines of the extreme dihedral angles.
struct DihedralCosines {
  double largest_cosine = 1;    ///< Cosine of the smallest angle.
  double smallest_cosine = -1;  ///< Cosine of the largest angle.
};

namespace detail {
/// Outward area normals (length = twice the area) of the faces opposite each vertex, for positive
/// orientation.
inline std::array<Vec3, 4> tetrahedron_face_normals(const Vec3& a, const Vec3& b, const Vec3& c,
                                                    const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const Vec3 opposite_b = w.cross(v), opposite_c = u.cross(w), opposite_d = v.cross(u);
  return {-(opposite_b + opposite_c + opposite_d), opposite_b, opposite_c, opposite_d};
}
}  // namespace detail

/// Extreme dihedral angles as cosines, without arc functions. The orientation is ignored (an inverted
/// tetrahedron has the angles of its mirror image): test the volume too. A face without area gives {1, -1},
/// the worst values.
[[nodiscard]] inline DihedralCosines min_max_dihedral(const Vec3& a, const Vec3& b, const Vec3& c,
                                                      const Vec3& d) {
  // Normals n_b, n_c, n_d of the faces opposite b, c, d, and minus that opposite a. By single numbers and
  // without arrays of normals: a third faster than by detail::tetrahedron_face_normals().
  const auto dot = [](const Vec3& x, const Vec3& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  const auto cross = [](const Vec3& x, const Vec3& y) {
    return Vec3(x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]);
  };
  const Vec3 u(b[0] - a[0], b[1] - a[1], b[2] - a[2]), v(c[0] - a[0], c[1] - a[1], c[2] - a[2]);
  const Vec3 w(d[0] - a[0], d[1] - a[1], d[2] - a[2]);
  const Vec3 n_b = cross(w, v), n_c = cross(u, w), n_d = cross(v, u);
  const Vec3 minus_n_a(n_b[0] + n_c[0] + n_d[0], n_b[1] + n_c[1] + n_d[1], n_b[2] + n_c[2] + n_d[2]);
  const double aa = dot(minus_n_a, minus_n_a), bb = dot(n_b, n_b), cc = dot(n_c, n_c), dd = dot(n_d, n_d);
  if (!(aa > 0) || !(bb > 0) || !(cc > 0) || !(dd > 0)) return {};
  const double ia = 1 / std::sqrt(aa), ib = 1 / std::sqrt(bb), ic = 1 / std::sqrt(cc), id = 1 / std::sqrt(dd);
  const std::array<double, 6> cosines = {dot(minus_n_a, n_b) * (ia * ib), dot(minus_n_a, n_c) * (ia * ic),
                                         dot(minus_n_a, n_d) * (ia * id), -dot(n_b, n_c) * (ib * ic),
                                         -dot(n_b, n_d) * (ib * id),      -dot(n_c, n_d) * (ic * id)};
  double largest = -1, smallest = 1;
  for (const double cosine : cosines) {
    largest = cosine > largest ? cosine : largest;  // Not std::max, whose references end up as branches.
    smallest = cosine < smallest ? cosine : smallest;
  }
  return {largest < 1 ? largest : 1, smallest > -1 ? smallest : -1};
}

/// The dihedral angles at the edges of kTetEdges, in degrees within [0, 180]; accurate near both ends. The
/// orientation is ignored as in min_max_dihedral().
[[nodiscard]] inline std::array<double, 6> dihedral_angles_deg(const Vec3& a, const Vec3& b, const Vec3& c,
                                                               const Vec3& d) {
  const auto normals = detail::tetrahedron_face_normals(a, b, c, d);
  const std::array<Vec3, 4> corners = {a, b, c, d};
  const double six_volumes = std::abs((b - a).cross(c - a).dot(d - a));
  std::array<double, 6> angles;
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    const auto [k, l] = kTetEdges[5 - e];  // The faces that share edge e are those opposite k and l.
    // |n_k x n_l| = 6 V |edge| gives the sine, which acos of the cosine would lose near 0 and 180 degrees.
    const double sine = six_volumes * (corners[j] - corners[i]).norm();
    angles[e] = std::atan2(sine, -normals[k].dot(normals[l])) * (180 / std::numbers::pi);
  }
  return angles;
}

/// Radius of the inscribed sphere, 3 V / (sum of face areas); negative if inverted, 0 if flat.
[[nodiscard]] inline double inradius(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto normals = detail::tetrahedron_face_normals(a, b, c, d);
  const double doubled_area = normals[0].norm() + normals[1].norm() + normals[2].norm() + normals[3].norm();
  return doubled_area > 0 ? 6 * tetrahedron_volume(a, b, c, d) / doubled_area : 0;
}

/// Longest edge / (2 sqrt(6) inradius), as Verdict and VTK's "aspect ratio": 1 for the regular tetrahedron,
/// growing without bound; infinite if flat or inverted. Source: Stimpson et al. 2007, Verdict
/// (SAND2007-1751), 7.2.
[[nodiscard]] inline double aspect_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double radius = inradius(a, b, c, d);
  if (!(radius > 0)) return std::numeric_limits<double>::infinity();
  const double longest = std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (d - a).squaredNorm(),
                                   (c - b).squaredNorm(), (d - b).squaredNorm(), (d - c).squaredNorm()});
  return std::sqrt(longest) / (2 * std::numbers::sqrt2 * std::numbers::sqrt3 * radius);
}

}  // namespace lumesh
