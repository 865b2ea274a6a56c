#include "lumesh/metric/gradation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

constexpr int kCells = 6;
constexpr double kLarge = 100;

/// A grid of unit cubes with large sizes but for one corner's.
TetMesh grid_with_small_corner(const Vec3& sizes_there) {
  TetMesh mesh = fixtures::cube_grid(kCells).build();
  mesh.enable_metric();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool corner = mesh.point(VertexId(v)).norm() == 0;
    const SymTensor metric = from_sizes(Mat3::Identity(), corner ? sizes_there : Vec3::Constant(kLarge));
    mesh.set_metric(VertexId(v), metric, log(metric));
  }
  return mesh;
}

/// Ascending sizes at a point of the grid.
Vec3 sizes_at(const TetMesh& mesh, const Vec3& point) {
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.point(VertexId(v)) == point) {
      const Vec3 values = eigen_system(mesh.metric(VertexId(v))).values;
      return {1 / std::sqrt(values[2]), 1 / std::sqrt(values[1]), 1 / std::sqrt(values[0])};
    }
  return Vec3::Zero();
}

/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028: eqs. (9) and (10) are one where sizes are round.
TEST(Gradation, LetsRoundSizesGrowByTheLogarithmOfTheGrowthPerDistance) {
  for (const double share : {0.0, 0.125, 1.0}) {
    TetMesh mesh = grid_with_small_corner(Vec3::Constant(0.1));
    limit_gradation(mesh, {.growth = 1.5, .physical_share = share, .tolerance = 1e-9});
    for (int k = 0; k <= kCells; ++k) {
      const Vec3 along = sizes_at(mesh, Vec3(k, 0, 0)), across = sizes_at(mesh, Vec3(k, k, k));
      EXPECT_LT((along - Vec3::Constant(0.1 + k * std::log(1.5))).norm(), 1e-6) << share << " " << k;
      EXPECT_LT((across - Vec3::Constant(0.1 + std::sqrt(3) * k * std::log(1.5))).norm(), 1e-6);
    }
  }
}

/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028, eq. (9), and eq. (10) at a share of 1.
TEST(Gradation, InMetricSpaceKeepsTheStretchAndInPhysicalSpaceLosesIt) {
  const auto stretch_next_to_corner = [](double share) {
    TetMesh mesh = grid_with_small_corner(Vec3(0.1, 1, 1));
    limit_gradation(mesh, {.growth = 1.5, .physical_share = share});
    const Vec3 sizes = sizes_at(mesh, Vec3(0, 0, 1));
    return sizes[2] / sizes[0];
  };
  EXPECT_NEAR(stretch_next_to_corner(0), 10, 1e-9);
  EXPECT_NEAR(stretch_next_to_corner(1), (1 + std::log(1.5)) / (0.1 + std::log(1.5)), 1e-9);
  EXPECT_LT(stretch_next_to_corner(0.125), 10);
}

std::vector<SymTensor> metrics_of(const TetMesh& mesh) {
  std::vector<SymTensor> metrics;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) metrics.push_back(mesh.metric(VertexId(v)));
  return metrics;
}

TEST(Gradation, MakesNoSizeLargerAndChangesNothingTwice) {
  TetMesh mesh = grid_with_small_corner(Vec3(0.1, 0.4, 2));
  const GradationOptions options{.growth = 1.3, .tolerance = 1e-9};
  const std::vector<SymTensor> before = metrics_of(mesh);
  limit_gradation(mesh, options);
  const std::vector<SymTensor> once = metrics_of(mesh);
  EXPECT_EQ(limit_gradation(mesh, options), 1);
  const std::vector<SymTensor> twice = metrics_of(mesh);
  for (std::size_t v = 0; v < before.size(); ++v) {
    EXPECT_GT(eigen_system(once[v] + (-1.0) * before[v]).values[0], -1e-9);
    EXPECT_LT((once[v].matrix() - twice[v].matrix()).norm(), 1e-7);
  }
}

TEST(Gradation, OnEveryNumberOfThreadsGivesTheSameBits) {
  TetMesh one = grid_with_small_corner(Vec3(0.1, 0.4, 2)), many = grid_with_small_corner(Vec3(0.1, 0.4, 2));
  {
    const parallel::ThreadLimit limit(1);
    limit_gradation(one);
  }
  limit_gradation(many);
  EXPECT_EQ(metrics_of(one), metrics_of(many));
}

TEST(Gradation, RefusesAGrowthOfOneOrLess) {
  TetMesh mesh = grid_with_small_corner(Vec3::Constant(1));
  EXPECT_THROW(limit_gradation(mesh, {.growth = 1}), Error);
  EXPECT_THROW(limit_gradation(mesh, {.growth = 2, .physical_share = 2}), Error);
}

}  // namespace
}  // namespace lumesh::metric
