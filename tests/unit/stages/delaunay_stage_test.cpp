// Delaunay meshes of surfaces that keep the surface's vertices.
#include "lumesh/stages/delaunay_stage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "fixtures/surfaces.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

/// Vertices of the boundary of a mesh of a surface with its vertices, after improvement.
std::vector<Vec3> boundary_with_vertices_of(const fixtures::TriangleSoup& surface, double delta_mm) {
  Context context;
  DelaunayRequest request;
  request.delaunay.delta_mm = delta_mm;
  const SurfaceDomain domain(surface.view(), {.keep_vertices = true});
  const DelaunayMesh made = make_delaunay_mesh(domain, request, nullptr, context);
  EXPECT_TRUE(validate(made.mesh).ok());
  EXPECT_GT(made.improved->after.min_deg, 15);
  std::set<std::uint32_t> used;
  for (const Cell<3>& corners : made.mesh.boundary_faces().triangles)
    used.insert(corners.begin(), corners.end());
  std::vector<Vec3> points;
  for (const std::uint32_t v : used) points.push_back(made.mesh.points()[v]);
  EXPECT_EQ(made.report.fixed_points_kept,
            std::count_if(surface.points.begin(), surface.points.end(), [&](const Vec3& p) {
              return std::find(points.begin(), points.end(), p) != points.end();
            }));
  return points;
}

double distance_to_nearest(const std::vector<Vec3>& points, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& p : points) least = std::min(least, (p - x).norm());
  return least;
}

/// With edges shorter than its own, all; else each that has no other vertex near by.
TEST(KeptVertices, AreKeptAsFarAsSizesAllow) {
  const fixtures::TriangleSoup ball = fixtures::icosphere(3, 2), cube = fixtures::unit_cube_surface();
  for (const auto& [surface, delta_mm] : {std::pair{&ball, 0.15}, {&cube, 0.1}}) {
    const std::vector<Vec3> points = boundary_with_vertices_of(*surface, delta_mm);
    for (const Vec3& vertex : surface->points) EXPECT_EQ(distance_to_nearest(points, vertex), 0);
  }
  constexpr double kCoarse = 0.5;
  const std::vector<Vec3> coarse = boundary_with_vertices_of(ball, kCoarse);
  EXPECT_LT(coarse.size(), ball.points.size());
  for (const Vec3& vertex : ball.points) EXPECT_LT(distance_to_nearest(coarse, vertex), kCoarse);
}

TEST(DelaunayStage, AWallWithCreasesKeepsThemAndIsOnePatch) {
  Context context;
  DelaunayRequest request;
  request.delaunay.delta_mm = 0.13;
  const fixtures::TriangleSoup cube = fixtures::unit_cube_surface();
  const SurfaceDomain domain(cube.view());
  const DelaunayMesh made = make_delaunay_mesh(domain, request, nullptr, context);
  const ValidationReport report = validate(made.mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  ASSERT_EQ(made.mesh.info().patches.size(), 1u);
  EXPECT_EQ(made.mesh.info().patches[0].name, "wall");
  EXPECT_NEAR(report.labels.at(0).volume, 1, 1e-9);
}

}  // namespace
}  // namespace lumesh
