#include "lumesh/metric/curvature_metric.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fixtures/analytic_domain.hpp"
#include "fixtures/curved_meshes.hpp"
#include "fixtures/meshes.hpp"
#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

/// Ascending.
Vec3 sizes_in(const SymTensor& metric) {
  const Vec3 values = eigen_system(metric).values;
  return {1 / std::sqrt(values[2]), 1 / std::sqrt(values[1]), 1 / std::sqrt(values[0])};
}

TEST(Curvature, OfASphereIsItsInverseRadiusEvenOnACoarseMesh) {
  for (const int halvings : {1, 2, 4}) {
    const fixtures::TriangleSoup sphere = fixtures::icosphere(halvings, 2.5);
    for (const SurfaceCurvature& found : fit_curvatures(sphere.points, sphere.triangles))
      for (const double curvature : found.curvatures) EXPECT_NEAR(std::abs(curvature) * 2.5, 1, 0.02);
  }
}

TEST(Curvature, OfATorusVariesAsItShould) {
  const double ring = 3, tube = 1;
  const fixtures::TriangleSoup torus = fixtures::torus_surface(ring, tube, 72, 24);
  const std::vector<SurfaceCurvature> curvatures = fit_curvatures(torus.points, torus.triangles);
  for (std::size_t v = 0; v < torus.points.size(); ++v) {
    const Vec3& p = torus.points[v];
    const double radius = p.head<2>().norm(), cosine = (radius - ring) / tube;
    // Of the same sign outside, of different ones inside; which is positive depends on how triangles turn.
    auto [low, high] = curvatures[v].curvatures;
    if (std::abs(low) > std::abs(high)) std::swap(low, high);
    const double product = cosine / (tube * radius);
    EXPECT_NEAR(std::abs(high), 1 / tube, 0.06);
    EXPECT_NEAR(low * high, product, 0.06);
  }
}

TEST(CurvatureMetric, OnABallGivesTheFormulasSizeEverywhere) {
  const TetMesh mesh = fixtures::ball(3);  // Of radius 1, with its middle.
  const auto expect_all = [&](const CurvatureOptions& options, double size) {
    const std::vector<SymTensor> metric = metric_from_curvature(mesh, options);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3 sizes = sizes_in(metric[v]);
      const double expected = mesh.dimension(VertexId(v)) == VertexDimension::kVolume ? 3.0 : size;
      EXPECT_NEAR(sizes[0] / expected, 1, 0.03);
      EXPECT_NEAR(sizes[2] / expected, 1, 0.03);
    }
  };
  expect_all({.edges_per_radius = 4, .largest_mm = 3}, 0.25);
  // A chord of 2 sin(a) stands 1 - cos(a) off the unit circle.
  expect_all({.chord_mm = 1 - std::cos(0.3), .largest_mm = 3}, 2 * std::sin(0.3));
}

TEST(CurvatureMetric, OnAPipeIsFineAroundAndCoarseAlongIt) {
  const TetMesh mesh = fixtures::quarter_pipe(6);
  const std::vector<SymTensor> metric = metric_from_curvature(mesh, {.edges_per_radius = 5, .largest_mm = 7});
  int on_arcs = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.dimension(VertexId(v)) != VertexDimension::kSurface) continue;
    const Vec3& p = mesh.points()[v];
    const double radius = p.head<2>().norm();
    const Vec3 sizes = sizes_in(metric[v]);
    const bool on_arc = std::min(std::abs(radius - 0.5), std::abs(radius - 1)) < 1e-9;
    if (!on_arc || std::min(p[0], p[1]) < 1e-9) continue;
    ++on_arcs;
    EXPECT_NEAR(sizes[0] / (radius / 5), 1, 0.05);
    EXPECT_GT(1 / std::sqrt(metric[v].zz), 6) << "along the axis";
  }
  EXPECT_GT(on_arcs, 10);
}

TEST(CurvatureMetric, OfADomainIsThatOfItsBoundaryHoweverCoarseTheMesh) {
  const TetMesh mesh = fixtures::ball(1);
  const std::vector<SymTensor> metric = metric_from_curvature(mesh, fixtures::analytic_ball(Vec3::Zero(), 1),
                                                              {.edges_per_radius = 4, .largest_mm = 3});
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 sizes = sizes_in(metric[v]);
    const double expected = mesh.dimension(VertexId(v)) == VertexDimension::kVolume ? 3.0 : 0.25;
    EXPECT_NEAR(sizes[0] / expected, 1, 0.01);
    EXPECT_NEAR(sizes[2] / expected, 1, 0.01);
  }
}

TEST(CurvatureMetric, OfACylindricalDomainIsUnboundedAlongTheAxis) {
  const TetMesh mesh = fixtures::quarter_pipe(4);  // Its outer side lies on the cylinder.
  const fixtures::AnalyticDomain domain = fixtures::analytic_cylinder(Vec3(0, 0, -9), Vec3(0, 0, 9), 1);
  const std::vector<SymTensor> metric =
      metric_from_curvature(mesh, domain, {.chord_mm = 0.02, .largest_mm = 7});
  const double around = 2 * std::sqrt(0.02 * 1.98);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.points()[v].head<2>().norm() < 1 - 1e-9) continue;
    const Vec3 sizes = sizes_in(metric[v]);
    EXPECT_NEAR(sizes[0] / around, 1, 0.01);
    EXPECT_NEAR(sizes[1] / around, 1, 0.01);
    EXPECT_NEAR(sizes[2], 7, 1e-6);
  }
}

TEST(CurvatureMetric, OfADomainElsewhereIsRefused) {
  EXPECT_THROW((void)metric_from_curvature(fixtures::ball(1), fixtures::analytic_ball(Vec3(30, 0, 0), 1)),
               Error);
}

TEST(CurvatureMetric, OfAPolyhedronIsTheLargestSize) {
  const TetMesh mesh = fixtures::cube_grid(4).build();
  for (const SymTensor& tensor : metric_from_curvature(mesh, {.largest_mm = 2}))
    EXPECT_LT((tensor.matrix() - Mat3::Identity() / 4).norm(), 1e-9);
  for (const SymTensor& tensor : metric_from_curvature(mesh))
    EXPECT_NEAR(sizes_in(tensor)[0], 4 * std::sqrt(3.0), 1e-6) << "the diagonal";
}

TEST(CurvatureMetric, OnEveryNumberOfThreadsGivesTheSameBits) {
  const TetMesh mesh = fixtures::ball(3);
  const std::vector<SymTensor> all = metric_from_curvature(mesh);
  const parallel::ThreadLimit limit(1);
  EXPECT_EQ(metric_from_curvature(mesh), all);
}

TEST(CurvatureMetric, RefusesOptionsOutOfRange) {
  const TetMesh mesh = fixtures::cube_of_6().build();
  EXPECT_THROW((void)metric_from_curvature(mesh, {.chord_mm = -1}), Error);
  EXPECT_THROW((void)metric_from_curvature(mesh, {.edges_per_radius = 0}), Error);
  EXPECT_THROW((void)metric_from_curvature(mesh, {.largest_mm = 0}), Error);
  EXPECT_THROW((void)metric_from_curvature(mesh, {.feature_angle_deg = 0}), Error);
}

}  // namespace
}  // namespace lumesh::metric
