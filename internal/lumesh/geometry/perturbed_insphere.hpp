#pragma once
/// @file The in-sphere test that never says "on it": a symbolic perturbation, with which every set of points
/// has exactly one Delaunay triangulation, whatever the order in which they come.

#include <array>

#include "lumesh/geometry/predicates.hpp"

namespace lumesh {

/// Order by x, then y, then z.
[[nodiscard]] inline bool precedes(const Vec3& a, const Vec3& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  if (a.y() != b.y()) return a.y() < b.y();
  return a.z() < b.z();
}

namespace detail {
/// insphere_perturbed() for points on one sphere.
bool holds_on_sphere(const std::array<const Vec3*, 4>& tet, const Vec3& e);
}  // namespace detail

/// True if `e` lies inside the sphere through the positively oriented (a, b, c, d). Points on one sphere
/// count as lifted off the paraboloid by infinitely small heights, the later one by precedes() the more: the
/// answers are those of one triangulation of all points (a regular one), without flat tetrahedra. All five
/// points differ. Source: Devillers and Teillaud 2011, Perturbations for Delaunay and weighted Delaunay 3D
/// triangulations, doi:10.1016/j.comgeo.2010.09.010.
[[nodiscard]] inline bool insphere_perturbed(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                             const Vec3& e) {
  const int sign = insphere(a, b, c, d, e);
  if (sign != 0) return sign > 0;
  return detail::holds_on_sphere({&a, &b, &c, &d}, e);
}

}  // namespace lumesh
