#include "../src/operators/angle_star.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>

namespace lumesh::operators {
namespace {

constexpr double kWeightOfObtuse = 0.65;

/// Tetrahedra from the origin to triangles just below it: flat within rounding, some of them.
void fill(AngleStar& star, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1), depth(0, 1);
  const double below = std::pow(10, -6.5 - 2 * depth(random));
  star.begin(kWeightOfObtuse);
  for (int i = 0; i < 6; ++i) {
    std::array<Vec3, 3> p;
    for (Vec3& q : p) q = Vec3(unit(random), unit(random), -below * depth(random));
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (normal.z() < 0) std::swap(p[1], p[2]);
    star.add(p[0], p[1], p[2]);
  }
}

/// Nothing is left over from the stars before.
TEST(AngleStar, ClimbsAsIfItHadNotClimbedBefore) {
  AngleStar used;
  int climbed = 0;
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    AngleStar fresh;
    for (AngleStar* star : {&used, &fresh}) {
      std::mt19937 random(seed);
      fill(*star, random);
    }
    Vec3 by_used = Vec3::Zero(), by_fresh = Vec3::Zero();
    const double quality = used.climb(by_used, 10);
    ASSERT_EQ(quality, fresh.climb(by_fresh, 10)) << seed;
    ASSERT_EQ(by_used, by_fresh) << seed;
    climbed += static_cast<int>(!by_used.isZero());
  }
  EXPECT_GT(climbed, 20);
}

}  // namespace
}  // namespace lumesh::operators
