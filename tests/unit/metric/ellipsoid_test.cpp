#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "../src/metric/ellipsoid_search.hpp"

namespace lumesh::metric {
namespace {

const Mat3 kTurn = Eigen::AngleAxisd(0.8, Vec3(1, -2, 3).normalized()).toRotationMatrix();
const Vec3 kFarAway(310, -205, 512);

Ellipsoid ellipsoid_around(std::span<const Vec3> points, const EllipsoidOptions& options = {}) {
  return EllipsoidSearch(options).around(points);
}

std::vector<Vec3> corners_of_box(const Vec3& half_edges) {
  std::vector<Vec3> corners;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1})
      for (const double z : {-1, 1}) corners.emplace_back(half_edges.cwiseProduct(Vec3(x, y, z)));
  return corners;
}

std::vector<Vec3> moved(std::vector<Vec3> points) {
  for (Vec3& p : points) p = kTurn * p + kFarAway;
  return points;
}

std::vector<Vec3> random_points(int count, const Vec3& extent, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> number;
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(extent.cwiseProduct(Vec3(number(random), number(random), number(random))));
  return points;
}

/// (x - c)^T M (x - c) of the point farthest out.
double farthest(const Ellipsoid& ellipsoid, const std::vector<Vec3>& points) {
  double most = 0;
  for (const Vec3& p : points) most = std::max(most, ellipsoid.metric().quadratic(p - ellipsoid.centre));
  return most;
}

void expect_semi_axes(const Ellipsoid& ellipsoid, const Vec3& expected, double share) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(ellipsoid.semi_axes[i] / expected[i], 1, share) << "axis " << i;
}

TEST(Ellipsoid, OfACubeIsTheBallThroughItsCorners) {
  const Ellipsoid ball = ellipsoid_around(moved(corners_of_box(Vec3::Ones())), {.tolerance = 1e-8});
  expect_semi_axes(ball, Vec3::Constant(std::sqrt(3.0)), 1e-7);
  EXPECT_LT((ball.centre - kFarAway).norm(), 1e-6);
}

TEST(Ellipsoid, OfABoxIsThatOfTheCubeStretched) {
  const Ellipsoid box = ellipsoid_around(moved(corners_of_box(Vec3(0.01, 1, 20))), {.tolerance = 1e-8});
  expect_semi_axes(box, std::sqrt(3.0) * Vec3(0.01, 1, 20), 1e-6);
  EXPECT_NEAR(std::abs(box.axes.col(2).dot(kTurn.col(2))), 1, 1e-9);
}

TEST(Ellipsoid, OfARegularSimplexIsTheBallThroughItsCorners) {
  const std::vector<Vec3> simplex = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  expect_semi_axes(ellipsoid_around(moved(simplex), {.tolerance = 1e-8}), Vec3::Constant(std::sqrt(3.0)),
                   1e-7);
  // Any simplex is an affine image of the regular one, and so is its ellipsoid of the ball: all corners lie
  // on it, and its centre is their mean.
  const std::vector<Vec3> any = {{0, 0, 0}, {5, 1, 0}, {0, 2, 0.5}, {1, 1, 0.3}};
  const Ellipsoid ellipsoid = ellipsoid_around(any, {.tolerance = 1e-9});
  EXPECT_LT((ellipsoid.centre - (any[0] + any[1] + any[2] + any[3]) / 4).norm(), 1e-7);
  for (const Vec3& p : any) EXPECT_NEAR(ellipsoid.metric().quadratic(p - ellipsoid.centre), 1, 1e-7);
}

TEST(Ellipsoid, OfPointsOnAnEllipsoidAndInItIsThat) {
  const Vec3 semi_axes(0.3, 2, 9);
  std::vector<Vec3> points;
  for (Vec3 p : random_points(500, Vec3::Ones(), 3)) {
    p.normalize();
    // With their opposites the directions balance: nothing smaller holds them all.
    points.emplace_back(semi_axes.cwiseProduct(p));
    points.emplace_back(-semi_axes.cwiseProduct(p));
    points.emplace_back(0.5 * semi_axes.cwiseProduct(p));
  }
  const Ellipsoid found = ellipsoid_around(moved(points), {.tolerance = 1e-5});
  expect_semi_axes(found, semi_axes, 0.02);
  EXPECT_LE(found.semi_axes.prod(), semi_axes.prod() * (1 + 1e-4));
}

TEST(Ellipsoid, EnclosesItsPointsAndIsNoLargerThanTheToleranceAllows) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const std::vector<Vec3> points = random_points(40, Vec3(0.1, 1, 10), seed);
    const double exact = ellipsoid_around(points, {.tolerance = 1e-7}).semi_axes.prod();
    for (const double tolerance : {0.2, 0.01}) {
      const Ellipsoid ellipsoid = ellipsoid_around(points, {.tolerance = tolerance});
      EXPECT_LT(farthest(ellipsoid, points), 1 + 1e-9);
      const double ratio = ellipsoid.semi_axes.prod() / exact;
      EXPECT_GE(ratio, 1 - 1e-6);
      EXPECT_LE(ratio, std::pow(1 + tolerance, 2)) << "tolerance " << tolerance << ", seed " << seed;
    }
  }
}

TEST(Ellipsoid, OfPointsOnALineHasHalfTheirRangeAndTheFloor) {
  std::vector<Vec3> line;
  for (int i = 0; i <= 10; ++i) line.emplace_back(0, 0.4 * i, 0);
  const Ellipsoid ellipsoid = ellipsoid_around(moved(line), {.floor_mm = 0.25});
  expect_semi_axes(ellipsoid, Vec3(0.25, 0.25, 2), 1e-12);
  EXPECT_NEAR(std::abs(ellipsoid.axes.col(2).dot(kTurn.col(1))), 1, 1e-12);
}

TEST(Ellipsoid, OfPointsInAPlaneIsTheEllipseAndTheFloor) {
  // The smallest ellipse around a rectangle has sqrt(2) times its half edges.
  const std::vector<Vec3> rectangle = {{-3, -1, 0}, {3, -1, 0}, {-3, 1, 0}, {3, 1, 0}, {1, 0.2, 0}};
  const Ellipsoid ellipsoid = ellipsoid_around(moved(rectangle), {.tolerance = 1e-8, .floor_mm = 0.125});
  expect_semi_axes(ellipsoid, Vec3(0.125, std::sqrt(2.0), 3 * std::sqrt(2.0)), 1e-7);
}

TEST(Ellipsoid, OfOnePlaceIsABallOfTheFloor) {
  const std::vector<Vec3> same(7, kFarAway);
  const Ellipsoid ellipsoid = ellipsoid_around(same, {.floor_mm = 0.5});
  EXPECT_EQ(ellipsoid.semi_axes, Vec3::Constant(0.5));
  EXPECT_LT((ellipsoid.centre - kFarAway).norm(), 1e-12);
}

TEST(Ellipsoid, NeedsNoFloorWhereThePointsSpanSpace) {
  const std::vector<Vec3> points = random_points(40, Vec3(1e-3, 1, 1e3), 5);
  const Ellipsoid ellipsoid = ellipsoid_around(points);
  EXPECT_GT(ellipsoid.semi_axes[0], 1e-3);
  EXPECT_LT(ellipsoid.semi_axes[0], 1e-2);
  EXPECT_LT(farthest(ellipsoid, points), 1 + 1e-3);
}

TEST(Ellipsoid, MovesWithItsPointsWhateverTheirOrder) {
  const std::vector<Vec3> points = random_points(40, Vec3(1, 2, 3), 11);
  std::vector<Vec3> shuffled = moved(points);
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(2));
  const EllipsoidOptions options{.tolerance = 1e-9};
  const Ellipsoid here = ellipsoid_around(points, options);
  const Ellipsoid there = ellipsoid_around(shuffled, options);
  EXPECT_LT((kTurn * here.centre + kFarAway - there.centre).norm(), 1e-5);
  EXPECT_LT((kTurn * here.metric().matrix() * kTurn.transpose() - there.metric().matrix()).norm(), 1e-5);
}

}  // namespace
}  // namespace lumesh::metric
