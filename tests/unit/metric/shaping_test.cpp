#include "lumesh/metric/shaping.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/tensor.hpp"

namespace lumesh::metric {
namespace {

/// Sizes between 0.03 and 30 along axes turned at random.
std::vector<SymTensor> wild_tensors(std::size_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1.5, 1.5);
  std::vector<SymTensor> tensors;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Quaterniond turn(number(random), number(random), number(random), number(random));
    const auto size = [&] { return std::pow(10, number(random)); };
    tensors.push_back(from_sizes(turn.normalized().toRotationMatrix(), Vec3(size(), size(), size())));
  }
  return tensors;
}

void expect_sizes_within(const TetMesh& mesh, double smallest, double largest, double aspect) {
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 values = eigen_system(mesh.metric(VertexId(v))).values;
    EXPECT_GE(1 / std::sqrt(values[2]), smallest * (1 - 1e-9));
    EXPECT_LE(1 / std::sqrt(values[0]), largest * (1 + 1e-9));
    EXPECT_LE(std::sqrt(values[2] / values[0]), aspect * (1 + 1e-9));
  }
}

TEST(Shaping, WithoutLimitsKeepsTheTensors) {
  TetMesh mesh = fixtures::cube_grid(3).build();
  const std::vector<SymTensor> wanted = wild_tensors(mesh.vertex_count());
  EXPECT_NEAR(shape_metric(mesh, wanted) / complexity(mesh, wanted), 1, 1e-12);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_EQ(mesh.metric(VertexId(v)), wanted[v]);
    EXPECT_LT((exp(mesh.log_metric(VertexId(v))).matrix() - wanted[v].matrix()).norm(),
              1e-9 * wanted[v].matrix().norm());
  }
}

TEST(Shaping, MeetsTheComplexityWithEveryLimitInForce) {
  TetMesh mesh = fixtures::cube_grid(4).build();
  const std::vector<SymTensor> wanted = wild_tensors(mesh.vertex_count());
  for (const double complexity : {300.0, 20000.0}) {
    const double seen = shape_metric(
        mesh, wanted,
        {.smallest_mm = 0.05, .largest_mm = 2, .max_aspect = 5, .growth = 1.5, .complexity = complexity});
    EXPECT_NEAR(seen / complexity, 1, 2e-3);
    EXPECT_NEAR(seen, metric::complexity(mesh), 1e-9 * seen);
    expect_sizes_within(mesh, 0.05, 2, 5);
  }
}

TEST(Shaping, ComesAsNearToTheComplexityAsBoundsLetIt) {
  TetMesh mesh = fixtures::cube_grid(2).build();  // Of volume 8.
  const std::vector<SymTensor> wanted = wild_tensors(mesh.vertex_count());
  EXPECT_NEAR(shape_metric(mesh, wanted, {.smallest_mm = 0.1, .complexity = 1e9}), 8e3, 1);
  EXPECT_NEAR(shape_metric(mesh, wanted, {.largest_mm = 0.1, .complexity = 1}), 8e3, 1);
  // Sizes that begin far above the largest are no end of the search.
  const std::vector<SymTensor> coarse(mesh.vertex_count(), SymTensor::diagonal(1e-8, 1e-8, 1e-8));
  EXPECT_NEAR(shape_metric(mesh, coarse, {.largest_mm = 1, .complexity = 1000}), 1000, 1);
}

TEST(Shaping, AspectShortensTheLongAxesOnly) {
  TetMesh mesh = fixtures::single_tet().build();
  const std::vector<SymTensor> wanted(4, from_sizes(Mat3::Identity(), Vec3(0.1, 0.5, 7)));
  shape_metric(mesh, wanted, {.max_aspect = 10});
  const SymTensor expected = from_sizes(Mat3::Identity(), Vec3(0.1, 0.5, 1));
  EXPECT_LT((mesh.metric(VertexId(0)).matrix() - expected.matrix()).norm(), 1e-9);
}

TEST(Shaping, RefusesContradictoryBounds) {
  TetMesh mesh = fixtures::single_tet().build();
  const std::vector<SymTensor> wanted(4, SymTensor::diagonal(1, 1, 1));
  try {
    shape_metric(mesh, wanted, {.smallest_mm = 2, .largest_mm = 1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
  }
  EXPECT_THROW(shape_metric(mesh, wanted, {.smallest_mm = -1}), Error);
  EXPECT_THROW(shape_metric(mesh, wanted, {.max_aspect = 0.5}), Error);
  EXPECT_THROW(shape_metric(mesh, wanted, {.growth = 1}), Error);
}

TEST(Shaping, IntersectingTakesTheFinerOfMetricsOfOneScale) {
  const TetMesh mesh = fixtures::cube_grid(2).build();
  const std::size_t n = mesh.vertex_count();
  const std::vector<SymTensor> a(n, SymTensor::diagonal(4, 1, 9)), b(n, SymTensor::diagonal(1, 16, 9));
  const auto as_they_are = intersected(mesh, {a, b}, 0);
  EXPECT_LT((as_they_are[1].matrix() - SymTensor::diagonal(4, 16, 9).matrix()).norm(), 1e-12);
  // Scaled to one complexity first, a is (4, 1, 9) and b (0.397, 6.35, 3.57): their determinants are equal.
  const auto scaled = intersected(mesh, {a, b}, complexity(mesh, a));
  const double scale = std::pow(36.0 / 144, 1.0 / 3);
  EXPECT_LT((scaled[1].matrix() - SymTensor::diagonal(4, 16 * scale, 9).matrix()).norm(), 1e-9);
}

TEST(Shaping, NearAFrozenBoundarySizesGoOverToThoseOfItsTriangles) {
  // Edges of 1 and sqrt(2) on the boundary of a cube of 12^3 cells; a tenth of that is wanted along x.
  TetMesh mesh = fixtures::cube_grid(12).build();
  const SymTensor wanted = SymTensor::diagonal(100, 1, 1);
  shape_metric(mesh, std::vector<SymTensor>(mesh.vertex_count(), wanted), {.keeps_boundary = true});
  double sum = 0, most = 0, edges = 0;
  for (const Cell<3>& triangle : mesh.boundary_faces().triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId a(triangle[k]), b(triangle[(k + 1) % 3]);
      const double length = edge_length(mesh.point(a), mesh.metric(a), mesh.point(b), mesh.metric(b));
      sum += length;
      most = std::max(most, length);
      ++edges;
    }
  EXPECT_NEAR(sum / edges, 1, 0.1);
  EXPECT_LT(most, 1.7);
  // In the middle, farther than the change of size, it is as wanted; on a face across x, so is the size
  // across.
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const VertexId v(i);
    const Vec3 x = mesh.point(v);
    const bool is_middle = (x - Vec3::Constant(6)).norm() < 0.1,
               is_on_face = (x - Vec3(0, 6, 6)).norm() < 0.1;
    if (is_middle) {
      EXPECT_EQ(mesh.metric(v), wanted);
    }
    if (is_on_face) {
      EXPECT_NEAR(mesh.metric(v).xx, 100, 1e-6);
    }
  }
}

TEST(Shaping, NearPatchesThatStayAloneSizesGoOverToThoseOfTheirTriangles) {
  // The interface x = 4 between two labels, of triangles with edges of 1 and sqrt(2); a fifth is wanted.
  TetMesh mesh = fixtures::two_label_block(8).build();
  const auto& patches = mesh.info().patches;
  const auto interface = std::find_if(patches.begin(), patches.end(),
                                      [](const Patch& patch) { return patch.kind == PatchKind::kInterface; });
  const PatchId kept(static_cast<std::uint32_t>(interface - patches.begin()));
  const SymTensor wanted = SymTensor::diagonal(25, 25, 25);
  shape_metric(mesh, std::vector<SymTensor>(mesh.vertex_count(), wanted),
               {.growth = 2, .kept_patches = {kept}});
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const VertexId v(i);
    const Vec3 x = mesh.point(v);
    // The change of 0.8 to 1.3 is over within as much, at the growth of 2.
    if (std::abs(x.x() - 4) > 1.5) {
      EXPECT_EQ(mesh.metric(v), wanted);
    }
    if (x.x() != 4) continue;
    EXPECT_LT(mesh.metric(v).yy, 2.5);
    EXPECT_NEAR(mesh.metric(v).xx, 25, 1e-6);
  }
}

TEST(WithinLimits, HoldsSizesAndThenTheStretch) {
  const auto with_sizes = [](double x, double y, double z) {
    return SymTensor::diagonal(1 / (x * x), 1 / (y * y), 1 / (z * z));
  };
  const SymTensor wanted = with_sizes(0.001, 1, 1000);
  const SymTensor in_bounds = within_limits(wanted, {.smallest_mm = 0.1, .largest_mm = 10});
  EXPECT_LT((in_bounds.matrix() - with_sizes(0.1, 1, 10).matrix()).norm(), 1e-9);
  const SymTensor round = within_limits(wanted, {.smallest_mm = 0.1, .max_aspect = 5});
  EXPECT_LT((round.matrix() - with_sizes(0.1, 0.5, 0.5).matrix()).norm(), 1e-9);
}

TEST(UnmetComplexity, IsToldFromOnePercentOn) {
  EXPECT_EQ(unmet_complexity(1005, {.complexity = 1000}), "");
  EXPECT_EQ(unmet_complexity(500, {}), "");
  const std::string bounds = unmet_complexity(980, {.largest_mm = 1, .complexity = 1000});
  EXPECT_NE(bounds.find("bounds on sizes"), std::string::npos);
  EXPECT_NE(bounds.find("980, not 1000"), std::string::npos);
  EXPECT_EQ(unmet_complexity(980, {.keeps_boundary = true, .complexity = 1000}).find("bounds"),
            std::string::npos);
}

}  // namespace
}  // namespace lumesh::metric
