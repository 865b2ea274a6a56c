// Points of surfaces stand closer where they bend, so that flat triangles stay near: against balls and
// cylinders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixtures/analytic_domain.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

struct BallSurface {
  std::size_t triangles = 0;
  double farthest_mm = 0;  // Of vertices and middles of triangles from the sphere.
};

BallSurface surface_of_ball(double radius_mm, double delta_mm, double surface_distance_mm) {
  const Vec3 centre(1, 2, 3);
  Context context;
  DelaunayOptions options;
  options.delta_mm = delta_mm;
  options.surface_distance_mm = surface_distance_mm;
  const TetMesh mesh = mesh_delaunay(fixtures::analytic_ball(centre, radius_mm), options, context).mesh;
  const ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
  const BoundaryFaces faces = mesh.boundary_faces();
  BallSurface surface{faces.triangles.size(), 0};
  for (const auto& [a, b, c] : faces.triangles) {
    const auto points = mesh.points();
    for (const Vec3& x : {points[a], points[b], points[c], Vec3((points[a] + points[b] + points[c]) / 3)})
      surface.farthest_mm = std::max(surface.farthest_mm, std::abs((x - centre).norm() - radius_mm));
  }
  return surface;
}

TEST(SurfaceDistance, TrianglesOfABallStayAsNearAsAsked) {
  const BallSurface free = surface_of_ball(10, 5, 0), near = surface_of_ball(10, 5, 0.15);
  EXPECT_GT(free.farthest_mm, 0.3);
  EXPECT_LT(near.farthest_mm, 1.3 * 0.15);
  EXPECT_GT(near.triangles, 3 * free.triangles);
}

/// A quarter of the curvature: edges twice as long on sixteen times the area. (Edges follow the powers of two
/// of an octree in part, so that other ratios tell less.)
TEST(SurfaceDistance, EdgesGrowWithTheRootOfTheRadius) {
  const BallSurface small = surface_of_ball(10, 5, 0.15), large = surface_of_ball(40, 5, 0.15);
  EXPECT_NEAR(static_cast<double>(large.triangles) / static_cast<double>(small.triangles), 4, 0.25);
  EXPECT_LT(large.farthest_mm, 1.3 * 0.15);
}

TEST(SurfaceDistance, WhatBendsLittleIsLeftToDelta) {
  EXPECT_EQ(surface_of_ball(10, 1, 0.2).triangles, surface_of_ball(10, 1, 0).triangles);
}

/// Flat ends stay coarse while the wall gets finer.
TEST(SurfaceDistance, FlatPartsAreLeftToDelta) {
  const auto triangles_of = [](double surface_distance_mm) {
    Context context;
    DelaunayOptions options;
    options.delta_mm = 0.8;
    options.surface_distance_mm = surface_distance_mm;
    const TetMesh mesh =
        mesh_delaunay(fixtures::analytic_cylinder({0, 0, 0}, {0, 0, 6}, 4), options, context).mesh;
    const BoundaryFaces faces = mesh.boundary_faces();
    std::array<double, 2> counts{};  // Of the wall, of the ends.
    for (const std::int32_t p : faces.patches)
      ++counts[mesh.info().patches[static_cast<std::size_t>(p)].kind == PatchKind::kOpening ? 1 : 0];
    return counts;
  };
  const auto [wall, ends] = triangles_of(0);
  const auto [near_wall, near_ends] = triangles_of(0.02);
  EXPECT_GT(near_wall, 1.5 * wall);
  EXPECT_LT(near_ends, 1.8 * ends);
}

}  // namespace
}  // namespace lumesh
