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

/// Vertices of the face opposite vertex f; their right-hand normal points out of a positively oriented
/// tetrahedron.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

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
/// negative for an inverted one; 0 if all points coincide. Source: Liu and Joe 1994, doi:10.1007/BF01955874.
[[nodiscard]] inline double mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double volume = tetrahedron_volume(a, b, c, d);
  const double edges = sum_of_squared_edges(a, b, c, d);
  if (!(edges > 0)) return 0;
  return std::copysign(12 * std::cbrt(9 * volume * volume) / edges, volume);
}

/// Cosines of the extreme dihedral angles.
struct DihedralCosines {
  double largest_cosine = 1;    ///< Of the smallest angle.
  double smallest_cosine = -1;  ///< Of the largest angle.
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
  const auto normals = detail::tetrahedron_face_normals(a, b, c, d);
  std::array<double, 4> inverse_length;
  for (int f = 0; f < 4; ++f) {
    const double squared = normals[f].squaredNorm();
    if (!(squared > 0)) return {};
    inverse_length[f] = 1 / std::sqrt(squared);
  }
  DihedralCosines result{-1, 1};
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const double cosine = -normals[i].dot(normals[j]) * inverse_length[i] * inverse_length[j];
      result.largest_cosine = std::max(result.largest_cosine, cosine);
      result.smallest_cosine = std::min(result.smallest_cosine, cosine);
    }
  result.largest_cosine = std::min(result.largest_cosine, 1.0);
  result.smallest_cosine = std::max(result.smallest_cosine, -1.0);
  return result;
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

/// Radius of the circumscribed sphere; infinite if flat.
[[nodiscard]] inline double circumradius(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double twelve_volumes = 2 * std::abs(u.cross(v).dot(w));
  if (!(twelve_volumes > 0)) return std::numeric_limits<double>::infinity();
  const Vec3 scaled =
      u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u) + w.squaredNorm() * u.cross(v);
  return scaled.norm() / twelve_volumes;
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

/// Circumradius / (3 inradius): 1 for the regular tetrahedron; infinite if flat or inverted.
[[nodiscard]] inline double radius_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double radius = inradius(a, b, c, d);
  if (!(radius > 0)) return std::numeric_limits<double>::infinity();
  return circumradius(a, b, c, d) / (3 * radius);
}

}  // namespace lumesh
