// The zero set of signed distances against the shapes that they are the distances of.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "field_fixtures.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/image/crossings.hpp"

namespace lumesh {
namespace {

struct BallError {
  double worst = 0, worst_normal_deg = 0;
};

BallError ball_error(const LabelField& field, const Vec3& centre, double radius) {
  BallError error;
  constexpr int kDirections = 2000;
  for (int n = 0; n < kDirections; ++n) {  // A Fibonacci spiral.
    const double z = 1 - (2 * n + 1.0) / kDirections, phi = 2.399963229728653 * n;
    const Vec3 out(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
    double low = 0.3 * radius, high = radius + 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (field.value(centre + middle * out, 1) > 0 ? low : high) = middle;
    }
    const Vec3 at = centre + low * out;
    constexpr double kStep = 1e-3;
    Vec3 gradient;
    for (int a = 0; a < 3; ++a)
      gradient[a] = field.value(at + kStep * Vec3::Unit(a), 1) - field.value(at - kStep * Vec3::Unit(a), 1);
    const double cosine = -gradient.normalized().dot(out);
    error.worst_normal_deg =
        std::max(error.worst_normal_deg, std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
    error.worst = std::max(error.worst, std::abs(low - radius));
  }
  return error;
}

TEST(SignedDistances, GiveTheRadiusAndTheNormalsOfBalls) {
  for (const double radius : {2.0, 3.3, 5.0, 8.4, 12.1}) {
    const int side = static_cast<int>(2 * radius) + 9;
    const Vec3 centre = Vec3::Constant(0.5 * side) + Vec3(0.13, -0.21, 0.37);
    std::vector<float> values;
    LabelImage image = image_of(frame_of({side, side, side}, Vec3::Ones()), 1, [&](const Vec3& p) {
      values.push_back(static_cast<float>(radius - (p - centre).norm()));
      return values.back() >= 0 ? 1 : 0;
    });
    static_cast<void>(find_crossings(std::span<const float>(values), 0, image, Interpolation::kQuadratic));
    const BallError error = ball_error(LabelField(image, {}), centre, radius);
    EXPECT_LT(error.worst, 0.02) << radius;
    EXPECT_LT(error.worst_normal_deg, 0.5) << radius;
  }
}

}  // namespace
}  // namespace lumesh
