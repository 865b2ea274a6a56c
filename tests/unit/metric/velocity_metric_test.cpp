#include "lumesh/metric/velocity_metric.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

std::vector<Vec3> places_in_box(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.emplace_back(number(random), number(random), number(random));
  return points;
}

std::vector<Vec3> velocities_at(const std::vector<Vec3>& points,
                                const std::function<Vec3(const Vec3&)>& field) {
  std::vector<Vec3> velocities;
  for (const Vec3& p : points) velocities.push_back(field(p));
  return velocities;
}

/// Ascending.
Vec3 sizes_of(const SymTensor& metric) {
  const Vec3 values = eigen_system(metric).values;
  return {1 / std::sqrt(values[2]), 1 / std::sqrt(values[1]), 1 / std::sqrt(values[0])};
}

std::string fault_of_samples(const std::vector<Vec3>& points, const std::vector<Vec3>& velocities) {
  try {
    (void)metric_from_velocity(places_in_box(10, 1), {points, velocities});
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "";
}

TEST(VelocityFit, OfALinearFieldIsItsGradient) {
  Mat3 gradient;
  gradient << 1, 2, -3, 0.5, -1, 4, 2, 0, 1.5;
  const std::vector<Vec3> points = places_in_box(2000, 1);
  const std::vector<Vec3> velocities =
      velocities_at(points, [&](const Vec3& x) -> Vec3 { return Vec3(5, -2, 1) + gradient * x; });
  for (const int k : {15, 20, 40})
    for (const VelocityFit& fit : fit_velocities(places_in_box(50, 2), {points, velocities}, k))
      EXPECT_LT((fit.gradient - gradient).norm(), 2e-4 * gradient.norm());
}

TEST(VelocityFit, OfThreeSamplesInterpolatesThemWithTheLeastGradient) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
  const std::vector<Vec3> velocities = {{1, 1, 1}, {4, 1, 1}, {1, 1, 5}};
  const std::vector<VelocityFit> fits =
      fit_velocities(std::vector<Vec3>{{0.3, 0.4, 0.2}, {-0.5, 1, 0}}, {points, velocities}, 3);
  Mat3 expected;  // 3 per unit of x, 2 per unit of y, and nothing is said about z.
  expected << 3, 0, 0, 0, 0, 0, 0, 2, 0;
  for (const VelocityFit& fit : fits) EXPECT_LT((fit.gradient - expected).norm(), 1e-4);
}

TEST(VelocityFit, OnALineSaysNothingAboutWhatLiesAcross) {
  std::vector<Vec3> points;
  for (int i = 0; i < 30; ++i) points.emplace_back(0.1 * i, 0, 0);
  const std::vector<Vec3> velocities = velocities_at(points, [](const Vec3& x) -> Vec3 {
    return {2 * x[0], 0, 0};
  });
  const VelocityFit fit =
      fit_velocities(std::vector<Vec3>{{1, 0.2, 0}, {2, 0, 0}}, {points, velocities}, 15)[0];
  EXPECT_NEAR(fit.gradient(0, 0), 2, 1e-4);
  EXPECT_LT((fit.gradient - 2 * Vec3::UnitX() * Vec3::UnitX().transpose()).norm(), 1e-4);
}

TEST(VelocityMetric, OfShearIsThinAlongTheGradientAndLongAlongTheFlow) {
  const std::vector<Vec3> points = places_in_box(3000, 1);
  const Mat3 axes = Eigen::Quaterniond(0.5, -0.3, 0.7, 0.2).normalized().toRotationMatrix();
  // Along the first axis, by 1 per unit of the second: |G| is 1 everywhere.
  const std::vector<Vec3> velocities =
      velocities_at(points, [&](const Vec3& x) -> Vec3 { return (2 + axes.col(1).dot(x)) * axes.col(0); });
  double squares = 0;
  for (const Vec3& u : velocities) squares += u.squaredNorm();
  const double thin = 0.3 * std::sqrt(squares / 3000);
  const VelocityMetricOptions options{.change = 0.3, .stretch = 30, .flatness = 3};
  for (const SymTensor& metric : metric_from_velocity(places_in_box(50, 2), {points, velocities}, options)) {
    const auto size_along = [&](int axis) { return 1 / std::sqrt(metric.quadratic(axes.col(axis))); };
    EXPECT_NEAR(size_along(0) / (30 * thin), 1, 1e-2);
    EXPECT_NEAR(size_along(1) / thin, 1, 1e-2);
    EXPECT_NEAR(size_along(2) / (3 * thin), 1, 1e-2);
  }
}

TEST(VelocityMetric, AcrossTheFlowSizesGoWithTheRootsOfTheRatesOfChange) {
  const std::vector<Vec3> points = places_in_box(3000, 1);
  // 35 times as fast along y as along z.
  const std::vector<Vec3> velocities = velocities_at(points, [](const Vec3& x) -> Vec3 {
    return {100 + 35 * x[1], x[2], 0};
  });
  const VelocityMetricOptions options{.stretch = 1000, .flatness = 1000};
  for (const SymTensor& metric : metric_from_velocity(places_in_box(50, 2), {points, velocities}, options))
    EXPECT_NEAR(std::sqrt(metric.yy / metric.zz), std::sqrt(35), 0.02 * std::sqrt(35));
}

TEST(VelocityMetric, IsNotLongAlongAFlowThatChangesAlongItself) {
  const std::vector<Vec3> points = places_in_box(2000, 1);
  const std::vector<Vec3> velocities = velocities_at(points, [](const Vec3& x) -> Vec3 {
    return {2 + x[0], 0, 0};
  });
  for (const SymTensor& metric :
       metric_from_velocity(places_in_box(50, 2), {points, velocities}, {.flatness = 2}))
    EXPECT_GT(metric.xx, 2 * metric.yy);
}

TEST(VelocityMetric, KeepsTheBoundsOfStretchAndFlatnessInEveryFlow) {
  const std::vector<Vec3> points = places_in_box(3000, 1), places = places_in_box(500, 2);
  const std::vector<Vec3> velocities = velocities_at(points, [](const Vec3& x) -> Vec3 {
    return {std::tanh(20 * x[1]), std::exp(3 * x[0]) * x[2], std::sin(9 * x[1] * x[2])};
  });
  const std::vector<SymTensor> metric =
      metric_from_velocity(places, {points, velocities}, {.stretch = 7, .flatness = 7});
  double smallest = 1e300, largest = 0;
  for (const SymTensor& tensor : metric) {
    const Vec3 sizes = sizes_of(tensor);
    smallest = std::min(smallest, sizes[0]);
    largest = std::max(largest, sizes[2]);
  }
  EXPECT_LE(largest / smallest, 7 * (1 + 1e-6));
  EXPECT_GT(largest / smallest, 3);
}

TEST(VelocityMetric, InATubeIsFinestAndMostStretchedAtTheWall) {
  std::vector<Vec3> points = places_in_box(20000, 1);
  for (Vec3& p : points) p[2] *= 3;
  std::erase_if(points, [](const Vec3& p) { return p.head<2>().norm() > 1; });
  const auto poiseuille = [](const Vec3& x) -> Vec3 { return {0, 0, 1 - x.head<2>().squaredNorm()}; };
  const std::vector<Vec3> velocities = velocities_at(points, poiseuille);
  std::vector<Vec3> places = points;
  places.resize(1000);
  places[0] = {0, 0, 0};
  places[1] = {0.5, 0, 0};
  places[2] = {0.96, 0, 0};
  const VelocityMetricOptions options;
  const std::vector<SymTensor> metric = metric_from_velocity(places, {points, velocities}, options);
  const Vec3 core = sizes_of(metric[0]), half = sizes_of(metric[1]), wall = sizes_of(metric[2]);
  EXPECT_LT(core[2] / core[0], 3);
  EXPECT_GT(core[0], 3 * wall[0]);
  EXPECT_NEAR(half[0] / wall[0], std::sqrt(2.0), 0.15);
  EXPECT_NEAR(wall[2] / wall[0], options.stretch, 0.1 * options.stretch);
  EXPECT_NEAR(wall[1] / wall[0], options.flatness, 0.1 * options.flatness);
  const Mat3 axes = eigen_system(metric[2]).axes;
  EXPECT_GT(std::abs(axes(2, 0)), 0.99) << "along the tube";
  EXPECT_GT(std::abs(axes(0, 2)), 0.98) << "thin along the radius";
}

TEST(VelocityMetric, DoesNotDependOnTheUnitOfTheVelocity) {
  const std::vector<Vec3> points = places_in_box(1000, 1), places = places_in_box(20, 2);
  const auto swirl = [](const Vec3& x) -> Vec3 { return {-x[1] * x[0], x[0], 1}; };
  std::vector<Vec3> velocities = velocities_at(points, swirl);
  const std::vector<SymTensor> metres = metric_from_velocity(places, {points, velocities});
  for (Vec3& u : velocities) u *= 1024;
  EXPECT_EQ(metric_from_velocity(places, {points, velocities}), metres);
}

TEST(VelocityMetric, OfNoFlowAndOfAConstantOneIsRound) {
  const std::vector<Vec3> points = places_in_box(500, 1), places = places_in_box(50, 2);
  for (const Vec3& constant : {Vec3(0, 0, 0), Vec3(0.3, -2, 1e3)}) {
    const std::vector<Vec3> velocities(points.size(), constant);
    for (const int k : {3, 20})
      for (const SymTensor& metric : metric_from_velocity(places, {points, velocities}, {.k = k})) {
        ASSERT_TRUE(is_metric(metric));
        const Vec3 sizes = sizes_of(metric);
        EXPECT_NEAR(sizes[2] / sizes[0], 1, 1e-6);
      }
  }
}

TEST(VelocityMetric, DoesNotDependOnOrderDuplicatesOrThreads) {
  std::vector<Vec3> points = places_in_box(1000, 1);
  const std::vector<Vec3> places = places_in_box(3000, 2);
  const auto swirl = [](const Vec3& x) -> Vec3 { return {-x[1] * x[0], x[0], 1}; };
  const std::vector<SymTensor> before = metric_from_velocity(places, {points, velocities_at(points, swirl)});
  std::shuffle(points.begin(), points.end(), std::mt19937(3));
  const parallel::ThreadLimit limit(1);
  EXPECT_EQ(metric_from_velocity(places, {points, velocities_at(points, swirl)}), before);
}

TEST(VelocityMetric, OfSamplesAtOnePlaceTakesTheMean) {
  std::vector<Vec3> points = places_in_box(100, 1);
  std::vector<Vec3> velocities(points.size(), Vec3(1, 0, 0));
  points.push_back(points[0]);
  velocities.push_back({0, 1, 0});
  velocities[0] = {0, -1, 0};
  EXPECT_LT(
      fit_velocities(std::vector<Vec3>{points[0], points[1]}, {points, velocities}, 3)[0].velocity.norm(), 1);
}

TEST(VelocityMetric, RefusesWhatIsNoFlow) {
  const std::vector<Vec3> points = places_in_box(50, 1);
  std::vector<Vec3> velocities(50, Vec3::UnitX());
  EXPECT_EQ(fault_of_samples(points, velocities), "");
  velocities[31][2] = std::nan("");
  EXPECT_NE(fault_of_samples(points, velocities).find("velocity of point 31"), std::string::npos);
  EXPECT_NE(fault_of_samples({}, {}).find("has only 0 different points"), std::string::npos);
  EXPECT_NE(fault_of_samples({points[0]}, {velocities[0]}).find("k asks for 20"), std::string::npos);
  std::vector<Vec3> far = points;
  for (Vec3& p : far) p += Vec3(100, 0, 0);
  EXPECT_NE(fault_of_samples(far, std::vector<Vec3>(50, Vec3::UnitX())).find("far from the mesh"),
            std::string::npos);
  const std::vector<Vec3> many = places_in_box(200, 1);
  std::vector<Vec3> in_metres = many;
  for (Vec3& p : in_metres) p *= 1e-3;
  EXPECT_NE(fault_of_samples(in_metres, std::vector<Vec3>(200, Vec3::UnitX())).find("another unit"),
            std::string::npos);
  EXPECT_EQ(fault_of_samples(many, std::vector<Vec3>(200, Vec3::UnitX())), "");
  EXPECT_THROW((void)metric_from_velocity(points, {points, points}, {.k = 2}), Error);
  EXPECT_THROW((void)metric_from_velocity(points, {points, points}, {.change = 0}), Error);
  EXPECT_THROW((void)metric_from_velocity(points, {points, points}, {.stretch = 0.5}), Error);
  EXPECT_THROW((void)metric_from_velocity(points, {points, points}, {.flatness = 0.5}), Error);
}

}  // namespace
}  // namespace lumesh::metric
