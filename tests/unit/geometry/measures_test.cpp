#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {
namespace {

// Regular, edge 2 sqrt(2), positively oriented.
const Vec3 kA(1, 1, 1), kB(1, -1, -1), kC(-1, -1, 1), kD(-1, 1, -1);
constexpr double kRegularDihedralDeg = 70.528779365509308;  // acos(1/3)

TEST(Tetrahedron, MeasuresOfTheRegularOneAreTextbookValues) {
  EXPECT_NEAR(tetrahedron_volume(kA, kB, kC, kD), 8.0 / 3,
              1e-14);  // A cube of edge 2 holds it: a third of 8.
  EXPECT_NEAR(mean_ratio(kA, kB, kC, kD), 1, 1e-14);
  EXPECT_NEAR(aspect_ratio(kA, kB, kC, kD), 1, 1e-14);
  EXPECT_NEAR(inradius(kA, kB, kC, kD), std::sqrt(3.0) / 3, 1e-14);
  for (const double angle : dihedral_angles_deg(kA, kB, kC, kD))
    EXPECT_NEAR(angle, kRegularDihedralDeg, 1e-12);
  const DihedralCosines extremes = min_max_dihedral(kA, kB, kC, kD);
  EXPECT_NEAR(extremes.largest_cosine, 1.0 / 3, 1e-14);
  EXPECT_NEAR(extremes.smallest_cosine, 1.0 / 3, 1e-14);
}

/// The mean ratio is that of Liu and Joe 1994, doi:10.1007/BF01955874.
TEST(Tetrahedron, CornerOfACubeHasKnownAnglesAtItsEdges) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(0, 0, 1);
  const auto angles = dihedral_angles_deg(a, b, c, d);
  for (int e = 0; e < 3; ++e) EXPECT_NEAR(angles[e], 90, 1e-12);                  // At the three axes.
  for (int e = 3; e < 6; ++e) EXPECT_NEAR(angles[e], 54.735610317245346, 1e-12);  // atan(sqrt(2))
  // 12 (1/2)^(2/3) / 9
  EXPECT_NEAR(mean_ratio(a, b, c, d), 0.83994736659658211, 1e-14);
  EXPECT_NEAR(inradius(a, b, c, d), 1 / (3 + std::sqrt(3.0)), 1e-14);  // 3V / (3/2 + sqrt(3)/2)
}

TEST(Tetrahedron, EdgeOrderFollowsTheTable) {
  // A wedge of 30 degrees along edge (2, 3): faces z = 0 and its rotation about the x axis.
  const double angle = 30 * std::numbers::pi / 180;
  const Vec3 a(0.5, 1, 0), b(0.5, std::cos(angle), std::sin(angle)), c(0, 0, 0), d(1, 0, 0);
  EXPECT_NEAR(dihedral_angles_deg(a, b, c, d)[5], 30, 1e-12);
  EXPECT_EQ(kTetEdges[5], (std::array<int, 2>{2, 3}));
}

TEST(Tetrahedron, InvertedOnesHaveNegativeQualityAndMirroredAngles) {
  EXPECT_NEAR(tetrahedron_volume(kA, kC, kB, kD), -8.0 / 3, 1e-14);
  EXPECT_NEAR(mean_ratio(kA, kC, kB, kD), -1, 1e-14);
  EXPECT_EQ(aspect_ratio(kA, kC, kB, kD), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(dihedral_angles_deg(kA, kC, kB, kD)[0], kRegularDihedralDeg, 1e-12);
}

TEST(Tetrahedron, FlatOnesGiveFiniteOrInfiniteButNeverNan) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(1, 1, 0);
  EXPECT_EQ(mean_ratio(a, b, c, d), 0);
  EXPECT_EQ(mean_ratio(a, a, a, a), 0);
  EXPECT_EQ(aspect_ratio(a, b, c, d), std::numeric_limits<double>::infinity());
  for (const double angle : dihedral_angles_deg(a, b, c, d))
    EXPECT_TRUE(angle == 0 || std::abs(angle - 180) < 1e-12);
  const DihedralCosines extremes = min_max_dihedral(a, b, a, d);
  EXPECT_EQ(extremes.largest_cosine, 1);
  EXPECT_EQ(extremes.smallest_cosine, -1);
}

TEST(Tetrahedron, KeepsTinyAnglesAccurate) {
  // Height 1e-9 over a base whose edge (0, 1) is 1 away from the foot: the angle there is atan(1e-9).
  const Vec3 a(-1, 0, 0), b(1, 0, 0), c(0, 3, 0), d(0, 1, 1e-9);
  EXPECT_NEAR(dihedral_angles_deg(a, b, c, d)[0] * std::numbers::pi / 180, 1e-9, 1e-20);
}

TEST(Tetrahedron, CosinesAgreeWithAnglesForRandomShapes) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = point(), b = point(), c = point(), d = point();
    const auto angles = dihedral_angles_deg(a, b, c, d);
    const DihedralCosines extremes = min_max_dihedral(a, b, c, d);
    const double to_rad = std::numbers::pi / 180;
    EXPECT_NEAR(extremes.largest_cosine, std::cos(*std::min_element(angles.begin(), angles.end()) * to_rad),
                1e-11);
    EXPECT_NEAR(extremes.smallest_cosine, std::cos(*std::max_element(angles.begin(), angles.end()) * to_rad),
                1e-11);
  }
}

TEST(Triangle, AreaAndNormalFollowTheRightHand) {
  EXPECT_NEAR(triangle_area(Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0)), 6, 1e-14);
  EXPECT_EQ(triangle_normal(Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0)), Vec3(0, 0, 1));
  EXPECT_EQ(triangle_normal(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)), Vec3(0, 0, 0));
}

TEST(ClosestPoint, FindsFaceEdgesAndCorners) {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  EXPECT_EQ(closest_point_on_triangle(Vec3(1, 1, 5), a, b, c), Vec3(1, 1, 0));
  EXPECT_EQ(closest_point_on_triangle(Vec3(2, -3, 1), a, b, c), Vec3(2, 0, 0));
  EXPECT_EQ(closest_point_on_triangle(Vec3(-1, 3, 1), a, b, c), Vec3(0, 3, 0));
  EXPECT_EQ(closest_point_on_triangle(Vec3(4, 4, 1), a, b, c), Vec3(2, 2, 0));
  EXPECT_EQ(closest_point_on_triangle(Vec3(-1, -1, 1), a, b, c), a);
  EXPECT_EQ(closest_point_on_triangle(Vec3(9, -1, 1), a, b, c), b);
  EXPECT_EQ(closest_point_on_triangle(Vec3(-1, 9, 1), a, b, c), c);
}

TEST(ClosestPoint, TreatsATriangleWithoutAreaAsItsEdges) {
  const Vec3 a(0, 0, 0), b(4, 0, 0);
  EXPECT_EQ(closest_point_on_triangle(Vec3(1, 2, 0), a, b, Vec3(2, 0, 0)), Vec3(1, 0, 0));
  EXPECT_EQ(closest_point_on_triangle(Vec3(1, 2, 0), a, a, a), a);
  EXPECT_EQ(closest_point_on_triangle(Vec3(1, 2, 0), a, b, b), Vec3(1, 0, 0));
}

}  // namespace
}  // namespace lumesh
