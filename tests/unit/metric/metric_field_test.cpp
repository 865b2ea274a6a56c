#include "lumesh/metric/metric_field.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fixtures/meshes.hpp"
#include "fixtures/metric_cubes.hpp"
#include "fixtures/rough_cube.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/metric/analytic.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"

namespace lumesh::metric {
namespace {

/// Size along a direction.
double size_along(const SymTensor& metric, const Vec3& direction) {
  return 1 / std::sqrt(metric.quadratic(direction.normalized()));
}

TEST(AnalyticMetric, HasTheSizesOfTheBenchmark) {
  const SymTensor linear = analytic_metric(AnalyticKind::kLinear, Vec3(0.3, 0.9, 0.75)).metric;
  EXPECT_NEAR(size_along(linear, Vec3(1, 0, 0)), 0.1, 1e-12);
  EXPECT_NEAR(size_along(linear, Vec3(0, 1, 0)), 0.1, 1e-12);
  EXPECT_NEAR(size_along(linear, Vec3(0, 0, 1)), 0.0505, 1e-12);  // Half way from 0.001 to 0.1.
  const Vec3 at_layer(0.3, 0.4, 0.1), radial(3, 4, 0), tangential(-4, 3, 0);
  const SymTensor polar1 = analytic_metric(AnalyticKind::kPolar1, at_layer).metric;
  EXPECT_NEAR(size_along(polar1, radial), 0.001, 1e-12);
  EXPECT_NEAR(size_along(polar1, tangential), 0.1, 1e-10);
  const SymTensor polar2 = analytic_metric(AnalyticKind::kPolar2, at_layer).metric;
  EXPECT_NEAR(size_along(polar2, tangential), 0.025, 1e-10);
  EXPECT_NEAR(size_along(polar2, Vec3(0, 0, 1)), 0.1, 1e-12);
  const SymTensor far = analytic_metric(AnalyticKind::kPolar2, Vec3(0.6, 0.8, 0), 0.5).metric;
  EXPECT_NEAR(size_along(far, radial), 0.05, 1e-12);  // r = 1: 0.1, with all sizes halved.
  EXPECT_NEAR(size_along(far, tangential), 0.05, 1e-12);
}

TEST(UniformMetric, HasOneSizeInAllDirections) {
  MetricField field = MetricField::uniform(0.5);
  MetricField::Hint hint = field.first_hint();
  field.scale_sizes(3);
  const MetricPair pair = field.at(Vec3(1, 2, 3), hint);
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(1, 2, -1)})
    EXPECT_NEAR(size_along(pair.metric, direction), 1.5, 1e-12);
  EXPECT_LT((log(pair.metric).matrix() - pair.log.matrix()).norm(), 1e-12);
}

TEST(AnalyticMetric, CarriesItsLogarithm) {
  for (const auto kind : {AnalyticKind::kLinear, AnalyticKind::kPolar1, AnalyticKind::kPolar2}) {
    for (const Vec3& p : {Vec3(0.3, 0.4, 0.2), Vec3(0, 0, 0), Vec3(0.9, 0.1, 0.5)}) {
      const MetricPair pair = analytic_metric(kind, p);
      EXPECT_LT((log(pair.metric).matrix() - pair.log.matrix()).norm(), 1e-8);
    }
  }
}

/// Two arms of 5 x 5 x 2 cubes that a bridge at y < 1 joins, between x = 0 and 5; logarithms vary linearly.
TetMesh arms_with_linear_log() {
  const fixtures::TetSoup grid = fixtures::cube_grid(5);
  fixtures::TetSoup soup;
  std::vector<std::uint32_t> number(grid.points.size(), ~0u);
  for (const Cell<4>& tet : grid.tets) {
    const Vec3 middle =
        0.25 * (grid.points[tet[0]] + grid.points[tet[1]] + grid.points[tet[2]] + grid.points[tet[3]]);
    if (middle[0] > 2 && middle[0] < 3 && middle[1] > 1) continue;
    Cell<4> corners = tet;
    for (std::uint32_t& v : corners) {
      if (number[v] == ~0u) {
        number[v] = static_cast<std::uint32_t>(soup.points.size());
        soup.points.push_back(grid.points[v]);
      }
      v = number[v];
    }
    soup.tets.push_back(corners);
    soup.labels.push_back(1);
  }
  TetMesh mesh = soup.build();
  mesh.enable_metric();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const double log_size = mesh.point(VertexId(v))[0];
    const SymTensor log = SymTensor::diagonal(-2 * log_size, -2 * log_size, -2 * log_size);
    mesh.set_metric(VertexId(v), exp(log), log);
  }
  return mesh;
}

TEST(BackgroundMetric, IsThatOfTheRightBranchWhereverTheSearchBegins) {
  const TetMesh mesh = arms_with_linear_log();
  const MetricField field = MetricField::on_background(arms_with_linear_log());
  for (const std::uint32_t start : {0u, mesh.tet_count() / 2, mesh.tet_count() - 1})
    for (const Vec3& p : {Vec3(0.3, 4.2, 2.1), Vec3(1.9, 4.9, 0.2), Vec3(3.1, 4.7, 4.6), Vec3(4.6, 3.3, 2.5),
                          Vec3(2.5, 0.6, 3.3), Vec3(2, 5, 5), Vec3(3, 5, 0)}) {
      MetricField::Hint hint(start);
      EXPECT_NEAR(std::log(size_along(field.at(p, hint).metric, Vec3(1, 0, 0))), p[0], 1e-9) << p.transpose();
    }
  MetricField::Hint hint = field.first_hint();  // In the gap, nearer to the right arm: that of its wall.
  EXPECT_NEAR(std::log(size_along(field.at(Vec3(2.8, 4, 2.5), hint).metric, Vec3(1, 0, 0))), 3, 1e-9);

  TetMesh same = arms_with_linear_log();
  assign_vertex_metrics(same, field);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_NEAR(same.log_metric(VertexId(v)).xx, mesh.log_metric(VertexId(v)).xx, 1e-9);
}

/// The cube [0, n]^3 with linearly varying logarithms of the metric.
TetMesh mesh_with_linear_log(int n) {
  TetMesh mesh = fixtures::cube_grid(n).build();
  mesh.enable_metric();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3& p = mesh.point(VertexId(v));
    const SymTensor log_metric{0.1 * p[0], 0.2, 0.05 * p[1], 1, 0, -0.3 * p[2]};
    mesh.set_metric(VertexId(v), exp(log_metric), log_metric);
  }
  return mesh;
}

/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028, section 2.3.2, eq. (3).
TEST(MetricField, OnABackgroundInterpolatesLogarithmsLinearly) {
  const MetricField field = MetricField::on_background(mesh_with_linear_log(4));
  MetricField::Hint hint = field.first_hint();
  for (const Vec3& p : {Vec3(0.3, 3.2, 1.9), Vec3(3.99, 0.01, 2.5), Vec3(2, 2, 2), Vec3(0, 0, 4)}) {
    const MetricPair pair = field.at(p, hint);
    const SymTensor expected{0.1 * p[0], 0.2, 0.05 * p[1], 1, 0, -0.3 * p[2]};
    EXPECT_LT((pair.log.matrix() - expected.matrix()).norm(), 1e-12);
    EXPECT_LT((pair.metric.matrix() - exp(expected).matrix()).norm(), 1e-6);
  }
}

/// A cube of bad angles with a logarithm at random at each vertex, always the same ones.
TetMesh mesh_with_random_logs() {
  TetMesh mesh = fixtures::rough_cube(6, 7);
  mesh.enable_metric();
  std::mt19937 random(5);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const double x = static_cast<double>(random()) / std::mt19937::max();
    const SymTensor log_metric = SymTensor::diagonal(x, x, x);
    mesh.set_metric(VertexId(v), exp(log_metric), log_metric);
  }
  return mesh;
}

/// By rounding such points often lie outside of all tetrahedra that share the edge or the face.
TEST(MetricField, IsTheMeanOfTheEndsInTheMiddleOfEdgesAndFaces) {
  const TetMesh mesh = mesh_with_random_logs();
  const MetricField field = MetricField::on_background(mesh_with_random_logs());
  MetricField::Hint hint = field.first_hint();
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    for (int i = 0; i < 4; ++i) {
      const auto log_at = [&](int corner) { return mesh.log_metric(mesh.vertex(TetId(t), corner % 4)).xx; };
      const auto place_of = [&](int corner) { return Vec3(mesh.corner(TetId(t), corner % 4)); };
      const Vec3 of_edge = 0.5 * (place_of(i) + place_of(i + 1));
      const Vec3 of_face = (place_of(i) + place_of(i + 1) + place_of(i + 2)) / 3;
      EXPECT_NEAR(field.at(of_edge, hint).log.xx, (log_at(i) + log_at(i + 1)) / 2, 1e-7);
      EXPECT_NEAR(field.at(of_face, hint).log.xx, (log_at(i) + log_at(i + 1) + log_at(i + 2)) / 3, 1e-7);
    }
}

TEST(MetricField, OutsideItsBackgroundTakesTheNearestValues) {
  const MetricField field = MetricField::on_background(mesh_with_linear_log(4));
  MetricField::Hint hint = field.first_hint();
  const MetricPair outside = field.at(Vec3(4.1, 2, 2), hint);
  EXPECT_NEAR(outside.log.xx, 0.4, 0.02);
}

TEST(MetricField, SizesScale) {
  MetricField field = MetricField::on_background(mesh_with_linear_log(3));
  MetricField::Hint hint = field.first_hint();
  const SymTensor before = field.at(Vec3(1, 1.5, 2), hint).metric;
  field.scale_sizes(0.5);
  const SymTensor after = field.at(Vec3(1, 1.5, 2), hint).metric;
  EXPECT_LT((after.matrix() - 4 * before.matrix()).norm(), 1e-12 * after.matrix().norm());
}

/// Loseille and Alauzet 2011, doi:10.1137/090754078; eqs. (1) and (2) of the paper (docs/paper.md).
TEST(Complexity, IsTheIntegralOfTheDensity) {
  fixtures::TetSoup soup = fixtures::cube_grid(16);
  for (Vec3& p : soup.points) p /= 4;
  TetMesh mesh = soup.build();
  mesh.enable_metric();
  const auto set_sizes = [&](auto sizes_at) {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const SymTensor metric = from_sizes(Mat3::Identity(), sizes_at(mesh.point(VertexId(v))));
      mesh.set_metric(VertexId(v), metric, log(metric));
    }
  };
  set_sizes([](const Vec3&) { return Vec3(0.5, 0.25, 2); });
  EXPECT_NEAR(complexity(mesh), 64 / 0.25, 1e-9);
  set_sizes([](const Vec3& p) { return Vec3(1, 1, 1 + p[2]); });
  EXPECT_NEAR(complexity(mesh), 16 * std::log(5.0), 0.005 * 16 * std::log(5.0));
}

TEST(Complexity, OfAFieldIsFoundOnACoarseMesh) {
  fixtures::TetSoup soup = fixtures::cube_grid(2);
  for (Vec3& p : soup.points) p /= 2;
  const TetMesh mesh = soup.build();
  // 100 times the integral of dz / (0.001 + 0.198 |z - 0.5|) over [0, 1].
  const double linear = 100 * 2 / 0.198 * std::log(1 + 0.198 * 0.5 / 0.001);
  EXPECT_NEAR(complexity(MetricField::analytic(AnalyticKind::kLinear), mesh), linear, 0.03 * linear);
  EXPECT_NEAR(complexity(MetricField::analytic(AnalyticKind::kLinear, 0.5), mesh), 8 * linear, 0.24 * linear);
  // Of polar-2 by the midpoint rule on 4000 x 4000 points.
  EXPECT_NEAR(complexity(MetricField::analytic(AnalyticKind::kPolar2), mesh), 7587, 0.03 * 7587);
}

TEST(Complexity, OfAFieldIsFoundOnAMeshThatIsFineInParts) {
  constexpr int n = 12;
  fixtures::TetSoup soup = fixtures::cube_grid(n);
  for (Vec3& p : soup.points) p /= n;
  const TetMesh mesh = soup.build();
  const double linear = 100 * 2 / 0.198 * std::log(1 + 0.198 * 0.5 / 0.001);
  EXPECT_NEAR(complexity(MetricField::analytic(AnalyticKind::kLinear), mesh), linear, 0.03 * linear);
  EXPECT_NEAR(complexity(MetricField::analytic(AnalyticKind::kPolar2), mesh), 7587, 0.03 * 7587);
}

TEST(AssignMetric, MeasuresQualities) {
  TetMesh mesh = fixtures::cube_grid(2).build();
  fixtures::assign_metric(mesh, MetricField::analytic(AnalyticKind::kLinear));
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i) {
    const TetId t(i);
    const auto log_of = [&](int k) -> const SymTensor& { return mesh.log_metric(mesh.vertex(t, k)); };
    EXPECT_FLOAT_EQ(mesh.quality(t), static_cast<float>(mean_ratio(
                                         mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2),
                                         mesh.corner(t, 3), log_of(0), log_of(1), log_of(2), log_of(3))));
  }
}

}  // namespace
}  // namespace lumesh::metric
