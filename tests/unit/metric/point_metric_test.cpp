#include "lumesh/metric/point_metric.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "../src/metric/ellipsoid_search.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

std::vector<Vec3> straight_line(int count, double spacing) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.emplace_back(0, 0, spacing * i);
  return points;
}

std::vector<Vec3> scattered(int count, unsigned seed, double extent = 10) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, extent);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.emplace_back(number(random), number(random), number(random));
  return points;
}

std::string fault_of(const std::vector<Vec3>& places, const std::vector<Vec3>& points,
                     const PointMetricOptions& options = {}) {
  try {
    (void)metric_from_points(places, points, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "";
}

TEST(PointMetric, AroundALineIsHalfItsNearestPointsLongAndOneSpacingThin) {
  const std::vector<Vec3> places = {{1, 0, 10.1}, {0, -2, 0}, {0.5, 0.5, 19.8}};
  for (const SymTensor& metric : metric_from_points(places, straight_line(100, 0.2), {.k = 11})) {
    EXPECT_NEAR(1 / std::sqrt(metric.zz), 1, 1e-9);
    EXPECT_NEAR(1 / std::sqrt(metric.xx), 0.2, 1e-9);
    EXPECT_NEAR(1 / std::sqrt(metric.yy), 0.2, 1e-9);
  }
}

std::vector<Vec3> circle(int count, double radius) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return points;
}

TEST(PointMetric, IsotropicSizesAreTheMeanDistanceToTheNearestPoints) {
  // On a line at one of its points: 0, twice 1 to 14, and 15 spacings.
  SymTensor metric = metric_from_points(std::vector<Vec3>{{0, 0, 10}}, straight_line(100, 0.2),
                                        {.k = 30, .isotropic = true})[0];
  for (const double value : {metric.xx, metric.yy, metric.zz})
    EXPECT_NEAR(1 / std::sqrt(value), 7.5 * 0.2, 1e-12);
  EXPECT_EQ(std::abs(metric.xy) + std::abs(metric.xz) + std::abs(metric.yz), 0);
  // On the axis of a circle all points are equally far: a triangle of 3, 4 and 5.
  std::vector<Vec3> points = circle(30, 3);
  points.emplace_back(0, 0, -2);
  const std::vector<Vec3> places = {{0, 0, 4}, {0, 0, 0}, {0, 0, -1}};
  const std::vector<SymTensor> found = metric_from_points(places, points, {.k = 30, .isotropic = true});
  EXPECT_NEAR(1 / std::sqrt(found[0].zz), 5, 1e-12);
  EXPECT_NEAR(1 / std::sqrt(found[1].zz), (29 * 3 + 2) / 30.0, 1e-12);
  EXPECT_NEAR(1 / std::sqrt(found[2].zz), (29 * std::sqrt(10) + 1) / 30.0, 1e-12);
}

TEST(PointMetric, IsotropicSizesHaveTheSpacingOfThePointsAsFloor) {
  const SymTensor metric = metric_from_points(std::vector<Vec3>{{0, 0, 5}}, straight_line(100, 0.2),
                                              {.k = 1, .isotropic = true})[0];
  EXPECT_NEAR(1 / std::sqrt(metric.xx), 0.2, 1e-9);
}

TEST(PointMetric, TakesTheFloorItIsGiven) {
  const auto metric =
      metric_from_points(std::vector<Vec3>{{0, 0, 5}}, straight_line(100, 0.2), {.k = 11, .floor_mm = 0.5});
  EXPECT_NEAR(1 / std::sqrt(metric[0].xx), 0.5, 1e-9);
}

TEST(PointMetric, IsTheEllipsoidOfTheNearestPoints) {
  const std::vector<Vec3> places = scattered(200, 1), points = scattered(3000, 2);
  const PointMetricOptions options{.k = 20, .tolerance = 1e-3, .floor_mm = 1e-3};
  const std::vector<SymTensor> found = metric_from_points(places, points, options);
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::vector<Vec3> sorted = points;
    std::sort(sorted.begin(), sorted.end(), [&](const Vec3& a, const Vec3& b) {
      return (a - places[i]).squaredNorm() < (b - places[i]).squaredNorm();
    });
    sorted.resize(20);
    const SymTensor expected = EllipsoidSearch({.tolerance = 1e-3, .floor_mm = 1e-3}).around(sorted).metric();
    // The order of the points differs, and with it where within the tolerance the search ends.
    EXPECT_LT((found[i].matrix() - expected.matrix()).norm(), 0.05 * expected.matrix().norm()) << i;
  }
}

TEST(PointMetric, DoesNotDependOnTheOrderOfPointsNorOnDuplicates) {
  // A grid has many points as near as one another.
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(i % 10, i / 10 % 10, i / 100);
  const std::vector<Vec3> places = {{4.5, 4.5, 4.5}, {3, 3, 3}, {0, 0, 0}, {7.5, 2, 1}};
  const std::vector<SymTensor> before = metric_from_points(places, points, {.k = 13});
  points.insert(points.end(), points.begin(), points.begin() + 500);
  std::shuffle(points.begin(), points.end(), std::mt19937(4));
  EXPECT_EQ(metric_from_points(places, points, {.k = 13}), before);
}

TEST(PointMetric, OfOnePlaceDoesNotDependOnTheOthers) {
  const std::vector<Vec3> points = straight_line(300, 0.1);
  const std::vector<Vec3> places = scattered(3000, 7);
  const std::vector<SymTensor> all = metric_from_points(places, points);
  for (std::size_t i = 0; i < places.size(); i += 250) {
    // Its own box would be a point, and all points far from that.
    const std::vector<Vec3> few = {places[i], Vec3::Zero(), Vec3::Constant(30)};
    EXPECT_EQ(metric_from_points(few, points)[0], all[i]);
  }
}

TEST(PointMetric, OnEveryNumberOfThreadsGivesTheSameBits) {
  const std::vector<Vec3> places = scattered(5000, 1), points = scattered(2000, 2);
  std::vector<SymTensor> one;
  {
    const parallel::ThreadLimit limit(1);
    one = metric_from_points(places, points);
  }
  EXPECT_EQ(metric_from_points(places, points), one);
}

TEST(PointMetric, RefusesSetsThatSayNothing) {
  const std::vector<Vec3> places = {{0, 0, 0}, {0, 0, 1}};
  EXPECT_NE(fault_of(places, {}).find("no points"), std::string::npos);
  EXPECT_NE(fault_of(places, std::vector<Vec3>(50, Vec3::Ones())).find("one place"), std::string::npos);
  EXPECT_NE(fault_of(places, straight_line(39, 0.1)).find("39 different points"), std::string::npos);
  std::vector<Vec3> broken = straight_line(50, 0.1);
  broken[7][1] = std::nan("");
  EXPECT_NE(fault_of(places, broken).find("point 7"), std::string::npos);
  EXPECT_THROW((void)metric_from_points(places, straight_line(50, 0.1), {.k = 0}), Error);
}

TEST(PointMetric, RefusesPointsFarOutsideAndSaysBothBoxes) {
  const std::vector<Vec3> places = {{0, 0, 0}, {1, 2, 2}};
  std::vector<Vec3> points = straight_line(50, 0.1);
  EXPECT_EQ(fault_of(places, points), "");
  for (Vec3& p : points) p += Vec3(-3.5, 0, 0);
  const std::string fault = fault_of(places, points);
  EXPECT_NE(fault.find("(-3.5, 0, 0) to (-3.5, 0, 4.9)"), std::string::npos) << fault;
  EXPECT_NE(fault.find("(0, 0, 0) to (1, 2, 2)"), std::string::npos) << fault;
}

}  // namespace
}  // namespace lumesh::metric
