#include "lift.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace lumesh::delaunay {

Vec3 lifted(const Domain& domain, const Vec3& x, Material first, Material second, double spacing) {
  if (domain.is_cut(first) || domain.is_cut(second)) return x;
  constexpr double kCircumradius = 0.75;  // Of triangles with edges of mean length, in spacings.
  constexpr double kMost = 0.15;          // In spacings; more is a corner, not a bend.
  const Vec3 gradient = domain.separation(x, first, second).gradient;
  const double slope = gradient.norm();
  if (!(slope > 1e-3)) return x;
  const Vec3 normal = gradient / slope;
  const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along);
  const double radius = kCircumradius * spacing;
  // Beyond the end of this boundary its function says nothing.
  if (domain.material_count() > 2 && domain.materials_near(x, radius).size() > 2) return x;
  double sum = 0;  // How much the surface falls off on the way to a circumference, to the side of `first`.
  for (const Vec3& direction : {along, across}) {
    sum += domain.separation_value(x + radius * direction, first, second);
    sum += domain.separation_value(x - radius * direction, first, second);
  }
  const double fall = 0.25 * sum / slope;
  return x + std::clamp(0.75 * fall, -kMost * spacing, kMost * spacing) * normal;
}

}  // namespace lumesh::delaunay
