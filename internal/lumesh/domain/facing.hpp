#pragma once
/// @file How triangles of a mesh stand to the domain's boundary.

#include <Eigen/Geometry>

#include "lumesh/domain/domain.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {

/// Cosine between a triangle's normal, out of the material inside, and the normal of the domain's boundary
/// beside its centroid: 1 where they agree, negative where the triangle is folded; 1 too where either has no
/// direction.
[[nodiscard]] inline double cosine_to_boundary(const Domain& domain, const Vec3& a, const Vec3& b,
                                               const Vec3& c, Material inside, Material outside) {
  const Vec3 outwards = (b - a).cross(c - a);
  const Vec3 inwards = domain.separation(triangle_centre(a, b, c), inside, outside).gradient;
  const double scale = outwards.norm() * inwards.norm();
  return scale > 0 ? -outwards.dot(inwards) / scale : 1;
}

}  // namespace lumesh
