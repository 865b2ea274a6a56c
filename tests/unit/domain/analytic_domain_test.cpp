// Domains given by formulas: volumes by counting, distances, and where materials meet.
#include "fixtures/analytic_domain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

constexpr double kPi = std::numbers::pi;

/// Volume of each label by random points in the box; within 3 standard errors of `truth`.
void expect_volumes(const Domain& domain, const std::map<Label, double>& truth) {
  constexpr int kPoints = 200000;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  const Box3 box = domain.bounds_mm();
  std::map<Label, double> found;
  for (int n = 0; n < kPoints; ++n) {
    const Vec3 x = box.min() + box.sizes().cwiseProduct(Vec3(share(random), share(random), share(random)));
    const Domain::Surroundings here = domain.surroundings(x);
    if (domain.is_meshed(here.material)) found[domain.label_of(here.material)] += box.volume() / kPoints;
  }
  ASSERT_EQ(found.size(), truth.size());
  for (const auto& [label, volume] : truth)
    EXPECT_NEAR(found[label], volume, 3 * std::sqrt(volume * box.volume() / kPoints)) << "label " << label;
}

/// Nothing changes within the clearance.
void expect_clearances_hold(const Domain& domain) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  std::normal_distribution<double> normal;
  const Box3 box = domain.bounds_mm();
  for (int n = 0; n < 20000; ++n) {
    const Vec3 x = box.min() + box.sizes().cwiseProduct(Vec3(share(random), share(random), share(random)));
    const Domain::Surroundings here = domain.surroundings(x);
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Material there = domain.material_at(x + 0.999 * here.clearance_mm * direction);
    if (domain.is_meshed(here.material) || domain.is_meshed(there)) {
      ASSERT_EQ(here.material, there) << x.transpose();
    }
  }
}

TEST(AnalyticDomain, HasTheVolumesOfItsShapes) {
  expect_volumes(fixtures::analytic_ball({1, 2, 3}, 2), {{1, 4 * kPi / 3 * 8}});
  expect_volumes(fixtures::analytic_box(Box3(Vec3(0, 0, 0), Vec3(1, 2, 3))), {{1, 6}});
  expect_volumes(fixtures::analytic_torus({1, 0, 0}, {1, 1, 1}, 3, 1), {{1, 2 * kPi * kPi * 3}});
  expect_volumes(fixtures::analytic_cylinder({0, 0, 1}, {0, 3, 5}, 1.5), {{1, kPi * 2.25 * 5}});
  expect_volumes(fixtures::analytic_nested_balls({0, 0, 0}, 1, 2), {{1, 4 * kPi / 3 * 7}, {2, 4 * kPi / 3}});
  // Two unit balls one apart: each loses a cap of height 1/2, pi h^2 (3 r - h) / 3.
  const double cap = kPi * 0.25 * 2.5 / 3;
  expect_volumes(fixtures::analytic_two_balls({0, 0, 0}, 1, {1, 0, 0}, 1),
                 {{1, 4 * kPi / 3 - cap}, {2, 4 * kPi / 3 - cap}});
}

TEST(AnalyticDomain, NothingChangesWithinTheClearance) {
  expect_clearances_hold(fixtures::analytic_box(Box3(Vec3(0, 0, 0), Vec3(1, 2, 3))));
  expect_clearances_hold(fixtures::analytic_torus({1, 0, 0}, {1, 1, 1}, 3, 1));
  expect_clearances_hold(fixtures::analytic_cylinder({0, 0, 1}, {0, 3, 5}, 1.5));
  expect_clearances_hold(fixtures::analytic_nested_balls({0, 0, 0}, 1, 2));
  expect_clearances_hold(fixtures::analytic_two_balls({0, 0, 0}, 1, {1.3, 0.2, 0}, 0.8));
}

TEST(AnalyticDomain, FindsCurvesAndCorners) {
  const fixtures::AnalyticDomain balls = fixtures::analytic_two_balls({0, 0, 0}, 1, {1, 0, 0}, 1);
  const auto on_circle = balls.project({0.6, 0.7, 0.1}, {0, 1, 2}, 1);
  ASSERT_TRUE(on_circle);
  EXPECT_NEAR(on_circle->x(), 0.5, 1e-9);
  EXPECT_NEAR(on_circle->norm(), 1, 1e-9);
  EXPECT_EQ(balls.materials_near(*on_circle, 1e-6), (MaterialSet{0, 1, 2}));
  EXPECT_EQ(balls.materials_near({0.5, 0, 0}, 0.1), (MaterialSet{1, 2}));
  EXPECT_EQ(balls.materials_near({-0.95, 0, 0}, 0.1), (MaterialSet{0, 1}));

  const fixtures::AnalyticDomain box = fixtures::analytic_box(Box3(Vec3(0, 0, 0), Vec3(1, 2, 3)));
  const auto corner = box.project({0.9, 1.8, 2.7}, {1, 3, 5, 7}, 1);
  ASSERT_TRUE(corner);
  EXPECT_LT((*corner - Vec3(1, 2, 3)).norm(), 1e-9);

  EXPECT_EQ(box.materials_near({1, 1.999, 1.5}, 0.01), (MaterialSet{1, 3, 5}));
  EXPECT_EQ(box.materials_near({1, 2.4, 1.5}, 0.01), (MaterialSet{5})) << "beyond one plane, on another";

  const fixtures::AnalyticDomain tube = fixtures::analytic_cylinder({0, 0, 0}, {0, 0, 4}, 1);
  const auto rim = tube.project({0.7, 0.5, 3.8}, {0, 1, 3}, 1);
  ASSERT_TRUE(rim);
  EXPECT_NEAR(rim->z(), 4, 1e-9);
  EXPECT_NEAR(std::hypot(rim->x(), rim->y()), 1, 1e-9);
}

TEST(AnalyticDomain, GradientsAreThoseOfTheValues) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-2, 3);
  const fixtures::AnalyticDomain torus = fixtures::analytic_torus({1, 0, 0}, {1, 1, 1}, 2, 0.5);
  const fixtures::AnalyticDomain tube = fixtures::analytic_cylinder({0, 0, 1}, {0, 3, 5}, 1.5);
  const fixtures::AnalyticDomain balls = fixtures::analytic_nested_balls({0, 0, 0}, 1, 2);
  for (const auto& [domain, a, b] : {std::tuple<const Domain*, Material, Material>{&torus, 1, 0},
                                     {&tube, 1, 0},
                                     {&tube, 1, 2},
                                     {&tube, 2, 3},
                                     {&balls, 1, 2},
                                     {&balls, 0, 1}})
    for (int n = 0; n < 200; ++n) {
      const Vec3 x(anywhere(random), anywhere(random), anywhere(random));
      const FieldSample here = domain->separation(x, a, b);
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 step = 1e-6 * Vec3::Unit(axis);
        const double slope =
            (domain->separation(x + step, a, b).value - domain->separation(x - step, a, b).value) / 2e-6;
        EXPECT_NEAR(here.gradient[axis], slope, 1e-4);
      }
    }
}

TEST(AnalyticDomain, RefusesWhatIsNoDomain) {
  const Box3 box(Vec3(0, 0, 0), Vec3(1, 1, 1));
  EXPECT_THROW(fixtures::AnalyticDomain({}, {box, 0.1, {}}), Error);
  EXPECT_THROW(fixtures::AnalyticDomain({{0, fixtures::everywhere_shape()}}, {box, 0.1, {}}), Error);
  EXPECT_THROW(fixtures::AnalyticDomain(
                   {{1, fixtures::everywhere_shape()}, {1, fixtures::everywhere_shape()}}, {box, 0.1, {}}),
               Error);
  EXPECT_THROW(fixtures::AnalyticDomain({{1, fixtures::everywhere_shape()}}, {box, 0, {}}), Error);
  EXPECT_THROW(fixtures::AnalyticDomain({{1, fixtures::everywhere_shape()}},
                                        {box, 0.1, {{Vec3::Zero(), Vec3::Zero()}}}),
               Error);
}

}  // namespace
}  // namespace lumesh
