#pragma once
// Where the zero sets of fields are, against the tubes that voxels were made of.

#include <cmath>
#include <random>

#include "field_fixtures.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh {

/// Where a ray from the axis, square to it, meets the zero set; NaN if nowhere up to `most` mm.
inline double radius_along(const LabelField& field, const Vec3& centre, const Vec3& direction, double most) {
  const auto value = [&](double r) { return field.value(field.frame().to_index(centre + r * direction), 1); };
  double low = 0, high = 0;
  for (double r = 0.05; r < most && high == 0; r += 0.05) {
    if (value(r) <= 0)
      high = r;
    else
      low = r;
  }
  if (high == 0) return std::nan("");
  for (int i = 0; i < 30; ++i) (value(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
  return low;
}

struct WallFigures {
  double mean = 0, roughness = 0, normal_deg = 0;
};

/// Radii and normals over the wall of a tube, away from the image's border.
inline WallFigures wall_of(const LabelField& field, const TubeAxis& axis, double radius, double half_length) {
  const Vec3 a =
      axis.direction.cross(std::abs(axis.direction.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
  const Vec3 b = axis.direction.cross(a);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  double sum = 0, squares = 0, angles = 0;
  const int count = 1500;
  for (int n = 0; n < count; ++n) {
    const double angle = 2 * M_PI * uniform(random);
    const Vec3 out = std::cos(angle) * a + std::sin(angle) * b;
    const Vec3 centre = axis.point + half_length * (2 * uniform(random) - 1) * axis.direction;
    const double r = radius_along(field, centre, out, radius + 2);
    EXPECT_TRUE(std::isfinite(r));
    const FieldSample s = field.sample(field.frame().to_index(centre + r * out), 1);
    const Vec3 normal = -s.gradient.cwiseQuotient(field.frame().spacing_mm).normalized();
    const double turn = std::acos(std::clamp(normal.dot(out), -1.0, 1.0)) * 180 / M_PI;
    sum += r - radius;
    squares += (r - radius) * (r - radius);
    angles += turn * turn;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(squares / count - mean * mean), std::sqrt(angles / count)};
}

inline LabelImage tube(const ImageFrame& frame, const TubeAxis& axis, double radius) {
  return image_of(frame, 1, [&](const Vec3& p) { return axis.distance(p) < radius ? 1 : 0; });
}

}  // namespace lumesh
