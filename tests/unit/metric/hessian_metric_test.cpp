#include "lumesh/metric/hessian_metric.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

/// A grid of unit cubes whose inner vertices are moved at random.
TetMesh rough_grid(int cells) {
  fixtures::TetSoup soup = fixtures::cube_grid(cells);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.15, 0.15);
  for (Vec3& p : soup.points)
    if (p.minCoeff() > 0 && p.maxCoeff() < cells) p += Vec3(shift(random), shift(random), shift(random));
  return soup.build();
}

std::vector<double> values_on(const TetMesh& mesh, const std::function<double(const Vec3&)>& function) {
  std::vector<double> values;
  for (const Vec3& p : mesh.points()) values.push_back(function(p));
  return values;
}

TEST(HessianRecovery, IsExactForQuadraticFunctionsEverywhere) {
  const SymTensor hessian{3, -1, 0.5, -2, 4, 7};
  const TetMesh mesh = rough_grid(5);
  const auto quadratic = [&](const Vec3& x) {
    return 4 + Vec3(1, -2, 5).dot(x) + hessian.quadratic(x - Vec3(2, 2, 2)) / 2;
  };
  for (const SymTensor& found : recover_hessians(mesh, values_on(mesh, quadratic)))
    EXPECT_LT((found.matrix() - hessian.matrix()).norm(), 1e-6);
}

TEST(HessianMetric, OfASaddleIsTheSameAsOfTheBowl) {
  const TetMesh mesh = rough_grid(4);
  const auto metric_of = [&](double sign) {
    return metric_from_hessian(mesh, values_on(mesh, [&](const Vec3& x) {
                                 return x[0] * x[0] + sign * 4 * x[1] * x[1] + 9 * x[2] * x[2];
                               }));
  };
  const std::vector<SymTensor> bowl = metric_of(1), saddle = metric_of(-1);
  for (std::size_t v = 0; v < bowl.size(); ++v) {
    EXPECT_LT((bowl[v].matrix() - saddle[v].matrix()).norm(), 1e-5 * bowl[v].matrix().norm());
    // Sizes go as the inverse roots of the second derivatives: 1, 1/2, 1/3.
    EXPECT_NEAR(std::sqrt(bowl[v].yy / bowl[v].xx), 2, 1e-4);
    EXPECT_NEAR(std::sqrt(bowl[v].zz / bowl[v].xx), 3, 1e-4);
  }
  EXPECT_NEAR(complexity(mesh, bowl), mesh.vertex_count() / 2.0, 1e-6);
}

/// Loseille and Alauzet 2011, doi:10.1137/10078654X, the optimal metric in Lp norm for n = 3.
TEST(HessianMetric, WeighsPlacesByTheNorm) {
  const TetMesh mesh = fixtures::cube_grid(12).build();
  const auto function = [](const Vec3& x) { return std::exp(0.25 * x[0]) + x[1] * x[1] + x[2] * x[2]; };
  const auto ratio_of = [&](double norm) {
    const std::vector<SymTensor> metric =
        metric_from_hessian(mesh, values_on(mesh, function), {.norm = norm});
    const auto density = [&](int i) {  // In the middle of a face of the grid x = i.
      return metric[static_cast<std::size_t>(i + 13 * (6 + 13 * 6))].determinant();
    };
    return density(8) / density(4);
  };
  // det |H| goes as exp(x / 4), det M as its power 1 - 3 / (2 p + 3).
  for (const double norm : {1.0, 2.0, 4.0})
    EXPECT_NEAR(std::log(ratio_of(norm)), (1 - 3 / (2 * norm + 3)), 0.03) << norm;
  EXPECT_NEAR(std::log(ratio_of(std::numeric_limits<double>::infinity())), 1, 0.03);
}

TEST(HessianMetric, AcrossAFrontIsFineAndAlongItCoarse) {
  const TetMesh mesh = fixtures::cube_grid(16).build();
  const Vec3 normal = Vec3(1, 2, -1).normalized();
  const auto front = [&](const Vec3& x) { return std::tanh(0.5 * normal.dot(x - Vec3(8, 8, 8))); };
  const std::vector<SymTensor> metric = metric_from_hessian(mesh, values_on(mesh, front));
  int beside = 0;
  for (std::size_t v = 0; v < metric.size(); ++v) {
    const Vec3& p = mesh.points()[v];
    const double distance = std::abs(normal.dot(p - Vec3(8, 8, 8)));
    if ((p - Vec3(8, 8, 8)).norm() > 5 || distance < 0.8 || distance > 2) continue;
    ++beside;
    const EigenSystem system = eigen_system(metric[v]);
    EXPECT_GT(std::abs(system.axes.col(2).dot(normal)), 0.98);
    EXPECT_GT(std::sqrt(system.values[2] / system.values[1]), 3);
  }
  EXPECT_GT(beside, 100);
}

TEST(HessianMetric, OfConstantAndLinearFunctionsIsRoundAndTheSameEverywhere) {
  const TetMesh mesh = rough_grid(4);
  for (const Vec3& slope : {Vec3(0, 0, 0), Vec3(1, -20, 3)})
    for (const double level : {0.0, 1e3}) {
      const std::vector<SymTensor> metric =
          metric_from_hessian(mesh, values_on(mesh, [&](const Vec3& x) { return level + slope.dot(x); }));
      for (const SymTensor& tensor : metric) {
        EXPECT_NEAR(tensor.xx / metric[0].xx, 1, 1e-12);
        EXPECT_EQ(tensor, SymTensor::diagonal(tensor.xx, tensor.xx, tensor.xx));
      }
    }
}

TEST(HessianMetric, OnEveryNumberOfThreadsGivesTheSameBits) {
  const TetMesh mesh = rough_grid(6);
  const std::vector<double> values =
      values_on(mesh, [](const Vec3& x) { return std::sin(x[0]) * std::cos(x[1] * x[2]); });
  const std::vector<SymTensor> all = metric_from_hessian(mesh, values);
  const parallel::ThreadLimit limit(1);
  EXPECT_EQ(metric_from_hessian(mesh, values), all);
}

TEST(HessianMetric, OfOneTetrahedronIsAMetric) {
  const TetMesh mesh = fixtures::single_tet().build();
  for (const SymTensor& tensor : metric_from_hessian(mesh, std::vector<double>{1, 2, 5, -3}))
    EXPECT_TRUE(is_metric(tensor));
}

TEST(HessianMetric, RefusesWhatIsNoNumberAndANormBelowOne) {
  const TetMesh mesh = fixtures::cube_grid(2).build();
  std::vector<double> values(mesh.vertex_count(), 1);
  EXPECT_THROW((void)metric_from_hessian(mesh, values, {.norm = 0.5}), Error);
  values[4] = std::nan("");
  try {
    (void)metric_from_hessian(mesh, values);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(error.what()).find("vertex 4"), std::string::npos);
  }
}

}  // namespace
}  // namespace lumesh::metric
