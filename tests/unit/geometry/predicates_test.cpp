#include "lumesh/geometry/predicates.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>

namespace lumesh {
namespace {

__extension__ typedef __int128 Wide;
using IntPoint = std::array<std::int64_t, 3>;

int sign(Wide value) {
  return value > 0 ? 1 : value < 0 ? -1 : 0;
}

Wide determinant3(const std::array<std::array<Wide, 3>, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// The truth in exact integers: sign of the determinant of (b-a, c-a, d-a).
int integer_orient3d(const std::array<IntPoint, 4>& p) {
  std::array<std::array<Wide, 3>, 3> m;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) m[i][k] = p[i + 1][k] - p[0][k];
  return sign(determinant3(m));
}

/// The truth in exact integers by a 4x4 determinant relative to the first point (another form than the
/// code's).
int integer_insphere(const std::array<IntPoint, 5>& p) {
  std::array<std::array<Wide, 4>, 4> m;
  for (int i = 0; i < 4; ++i) {
    m[i][3] = 0;
    for (int k = 0; k < 3; ++k) {
      m[i][k] = p[i + 1][k] - p[0][k];
      m[i][3] += m[i][k] * m[i][k];
    }
  }
  Wide determinant = 0;
  for (int column = 0; column < 4; ++column) {
    std::array<std::array<Wide, 3>, 3> minor;
    for (int i = 1; i < 4; ++i)
      for (int k = 0, to = 0; k < 4; ++k)
        if (k != column) minor[i - 1][to++] = m[i][k];
    determinant += (column % 2 == 0 ? 1 : -1) * m[0][column] * determinant3(minor);
  }
  // Lifted onto the paraboloid, a point inside the sphere lies below the hyperplane of the other four.
  return -sign(determinant);
}

Vec3 to_point(const IntPoint& p, double scale) {
  return Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])) * scale;
}

constexpr unsigned kSeed = 20240611;

template <std::size_t N>
std::array<IntPoint, N> random_points(std::mt19937_64& random, std::int64_t range) {
  std::uniform_int_distribution<std::int64_t> coordinate(-range, range);
  std::array<IntPoint, N> points;
  for (IntPoint& p : points)
    for (std::int64_t& x : p) x = coordinate(random);
  return points;
}

TEST(Orient3d, IsPositiveForTheVtkTetrahedron) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(0, 0, 1);
  EXPECT_EQ(orient3d(a, b, c, d), 1);
  EXPECT_EQ(orient3d(a, c, b, d), -1);
  EXPECT_EQ(orient3d(a, b, c, Vec3(0.3, 0.3, 0)), 0);
}

TEST(Orient3d, AgreesWithIntegersOnRandomAndDegeneratePoints) {
  std::mt19937_64 random(kSeed);
  std::array<int, 3> seen = {0, 0, 0};
  for (const std::int64_t range : {1ll, 2ll, 5ll, 1000ll, 1ll << 38})  // Small grids are mostly degenerate.
    for (const double scale : {1.0, 0x1p-30})
      for (int i = 0; i < 10000; ++i) {
        const auto p = random_points<4>(random, range);
        const int truth = integer_orient3d(p);
        ++seen[truth + 1];
        ASSERT_EQ(orient3d(to_point(p[0], scale), to_point(p[1], scale), to_point(p[2], scale),
                           to_point(p[3], scale)),
                  truth)
            << "seed " << kSeed << " range " << range << " case " << i;
      }
  for (const int count : seen) EXPECT_GT(count, 1000);
}

TEST(Orient3d, SeesOneUnitInTheLastPlaceOffAPlane) {
  // Points of the plane x + y + z = 2^40; moving one coordinate of d by 1 decides the sign.
  std::mt19937_64 random(kSeed);
  std::uniform_int_distribution<std::int64_t> coordinate(0, 1ll << 39);
  for (int i = 0; i < 5000; ++i) {
    std::array<IntPoint, 4> p;
    for (IntPoint& q : p) {
      q[0] = coordinate(random);
      q[1] = coordinate(random);
      q[2] = (1ll << 40) - q[0] - q[1];
    }
    for (const std::int64_t step : {-1, 0, 1}) {
      auto moved = p;
      moved[3][2] += step;
      const int truth = integer_orient3d(moved);
      if (step == 0) {
        ASSERT_EQ(truth, 0);
      }
      ASSERT_EQ(orient3d(to_point(moved[0], 1), to_point(moved[1], 1), to_point(moved[2], 1),
                         to_point(moved[3], 1)),
                truth)
          << "seed " << kSeed << " case " << i;
    }
  }
}

TEST(Orient3d, IsAntisymmetricOnNearlyFlatPoints) {
  // Kettner et al. 2008: a grid of neighbouring doubles around a plane, where naive evaluation contradicts
  // itself.
  // The plane is x = y, so the sign is that of i - j.
  const Vec3 a(12, 12, 0), b(24, 24, 0), c(12, 12, 1);
  const double step = 0x1p-53;
  int disagreements_with_rounding = 0;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j) {
      const Vec3 d = Vec3(0.5 + i * step, 0.5 + j * step, 0.3);
      const int value = orient3d(a, b, c, d);
      ASSERT_EQ(value, (i > j) - (i < j));
      ASSERT_EQ(orient3d(b, c, a, d), value);
      ASSERT_EQ(orient3d(b, a, c, d), -value);
      ASSERT_EQ(orient3d(a, b, d, c), -value);
      ASSERT_EQ(orient3d(d, c, b, a), value);
      const double rounded = (b - a).cross(c - a).dot(d - a);
      disagreements_with_rounding += (rounded > 0) - (rounded < 0) != value;
    }
  EXPECT_GT(disagreements_with_rounding, 0);  // Otherwise these points test nothing.
}

TEST(Orient3d, SurvivesExtremeMagnitudes) {
  for (const double scale : {1e-300, 1e-150, 1e-60, 1e60, 1e100, 1e150, 1e300}) {
    const Vec3 a(0, 0, 0), b(scale, 0, 0), c(0, scale, 0), d(0.25 * scale, 0.25 * scale, scale);
    EXPECT_EQ(orient3d(a, b, c, d), 1) << scale;
    EXPECT_EQ(orient3d(a, c, b, d), -1) << scale;
  }
  EXPECT_EQ(orient3d(Vec3(0, 0, 0), Vec3(1e200, 0, 0), Vec3(0, 1e-200, 0), Vec3(0, 0, 1e-150)), 1);
  EXPECT_EQ(orient3d(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 5e-324)), 1);
}

TEST(Insphere, KnowsInsideOutsideAndOn) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(0, 0, 1);
  EXPECT_EQ(insphere(a, b, c, d, Vec3(0.5, 0.5, 0.5)), 1);
  EXPECT_EQ(insphere(a, b, c, d, Vec3(2, 2, 2)), -1);
  EXPECT_EQ(insphere(a, b, c, d, Vec3(1, 1, 1)), 0);
  EXPECT_EQ(insphere(a, c, b, d, Vec3(0.5, 0.5, 0.5)), -1);
}

TEST(Insphere, AgreesWithIntegersOnRandomAndCosphericalPoints) {
  std::mt19937_64 random(kSeed + 1);
  std::array<int, 3> seen = {0, 0, 0};
  for (const std::int64_t range : {1ll, 2ll, 7ll, 1000ll, 1ll << 20})
    for (int i = 0; i < 10000; ++i) {
      const auto p = random_points<5>(random, range);
      const int truth = integer_insphere(p);
      ++seen[truth + 1];
      ASSERT_EQ(insphere(to_point(p[0], 1), to_point(p[1], 1), to_point(p[2], 1), to_point(p[3], 1),
                         to_point(p[4], 1)),
                truth)
          << "seed " << kSeed + 1 << " range " << range << " case " << i;
    }
  for (const int count : seen) EXPECT_GT(count, 1000);
}

TEST(Insphere, SeesOneUnitOffASphereFarFromTheOrigin) {
  // The corners of a lattice cube are cospherical (the rule in a body-centred lattice); one of them moves
  // by 1.
  const std::int64_t far = 1ll << 22, edge = 1ll << 19;
  std::array<IntPoint, 5> p = {{{far, far, far},
                                {far + edge, far, far},
                                {far, far + edge, far},
                                {far, far, far + edge},
                                {far + edge, far + edge, far + edge}}};
  const auto value = [](const std::array<IntPoint, 5>& q) {
    return insphere(to_point(q[0], 1), to_point(q[1], 1), to_point(q[2], 1), to_point(q[3], 1),
                    to_point(q[4], 1));
  };
  EXPECT_EQ(value(p), 0);
  p[4][0] += 1;
  EXPECT_EQ(value(p), -1);
  p[4][0] -= 2;
  EXPECT_EQ(value(p), 1);
}

TEST(Insphere, ExchangingTwoPointsFlipsTheSign) {
  std::mt19937_64 random(kSeed + 2);
  for (int i = 0; i < 2000; ++i) {
    const auto p = random_points<5>(random, 3);
    std::array<Vec3, 5> q;
    for (int k = 0; k < 5; ++k) q[k] = to_point(p[k], 0.1);
    const int value = insphere(q[0], q[1], q[2], q[3], q[4]);
    EXPECT_EQ(insphere(q[1], q[0], q[2], q[3], q[4]), -value);
    EXPECT_EQ(insphere(q[0], q[1], q[3], q[2], q[4]), -value);
    EXPECT_EQ(insphere(q[4], q[1], q[2], q[3], q[0]), -value);
  }
}

TEST(Orient2d, AgreesWithIntegersOnRandomAndCollinearPoints) {
  std::mt19937_64 random(kSeed + 3);
  for (const std::int64_t range : {1ll, 3ll, 1ll << 40})
    for (int i = 0; i < 10000; ++i) {
      const auto p = random_points<3>(random, range);
      const Wide truth = static_cast<Wide>(p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                         static_cast<Wide>(p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
      const auto point = [&](int k) { return Vec2(to_point(p[k], 1).head<2>()); };
      ASSERT_EQ(orient2d(point(0), point(1), point(2)), sign(truth)) << "seed " << kSeed + 3 << " case " << i;
    }
  EXPECT_EQ(orient2d(Vec2(0, 0), Vec2(1e-200, 0), Vec2(0, 1e-200)), 1);
}

}  // namespace
}  // namespace lumesh
