// Contours of what is inside: against formulas of bodies.
#include "lumesh/surface/contour.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fixtures/surfaces.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

TriangleMesh contoured_body(const fixtures::TriangleSoup& soup) {
  return {soup.points, soup.triangles, std::vector<std::int32_t>(soup.triangles.size(), 0)};
}

double enclosed_volume(const Contour& contour) {
  double volume = 0;
  for (const auto& [a, b, c] : contour.triangles)
    volume += tetrahedron_volume(Vec3(Vec3::Zero()), contour.points[a], contour.points[b], contour.points[c]);
  return volume;
}

void expect_embedded_manifold(const Contour& contour) {
  for_each_edge(sorted_sides(contour.triangles), [&](std::span<const TriangleSide> sides) {
    ASSERT_EQ(sides.size(), 2U);
    EXPECT_NE(sides[0].runs_up(contour.triangles[sides[0].triangle]),
              sides[1].runs_up(contour.triangles[sides[1].triangle]));
  });
  EXPECT_TRUE(find_self_crossings(contour.points, contour.triangles).empty());
}

Contour even_contour(const TriangleMesh& given, double spacing) {
  Contour contour = contour_of_inside(given, grid_around(given.points, spacing));
  expect_embedded_manifold(contour);
  make_even(contour, given, TriangleTree(given.points, given.triangles), spacing);
  expect_embedded_manifold(contour);
  return contour;
}

TEST(Contour, OfABallIsABall) {
  const Contour contour = even_contour(contoured_body(fixtures::icosphere(5, 10)), 1);
  EXPECT_EQ(contour.euler_number(), 2);
  EXPECT_NEAR(enclosed_volume(contour), 4.0 / 3 * std::numbers::pi * 1000, 0.02 * 4189);
  for (const Vec3& p : contour.points) EXPECT_NEAR(p.norm(), 10, 0.05);
}

TEST(Contour, OfATorusHasItsHandle) {
  const Contour contour = even_contour(contoured_body(fixtures::torus_surface(10, 4, 120, 60)), 0.8);
  EXPECT_EQ(contour.euler_number(), 0);
  EXPECT_EQ(contour.count_parts(), 1U);
  const double volume = 2 * std::numbers::pi * std::numbers::pi * 10 * 16;
  EXPECT_NEAR(enclosed_volume(contour), volume, 0.03 * volume);
}

// Sharp edges are kept: points of the cube's edges are vertices, so that nothing of it is far off.
TEST(Contour, OfACubeWithFacesInTheGridsPlanesIsTheCube) {
  const TriangleMesh cube =
      contoured_body(fixtures::unit_cube_surface().moved([](const Vec3& p) { return Vec3(10 * p); }));
  PointGrid grid{Vec3::Constant(-2), 1, Index3::Constant(15)};
  Contour contour = contour_of_inside(cube, grid);
  expect_embedded_manifold(contour);
  make_even(contour, cube, TriangleTree(cube.points, cube.triangles), grid.spacing_mm);
  expect_embedded_manifold(contour);
  EXPECT_EQ(contour.euler_number(), 2);
  EXPECT_NEAR(enclosed_volume(contour), 1000, 15);
  const TriangleTree made(contour.points, contour.triangles);
  for (double at = 2; at < 8; at += 0.25) EXPECT_LT(made.nearest(Vec3(at, 10, 0)).distance, 0.25) << at;
}

// Two balls of radius 10 with centres 10 apart: a lens of 5/12 pi 10^3 is in both.
TEST(Contour, OfBallsThatCrossIsTheirUnion) {
  fixtures::TriangleSoup balls = fixtures::icosphere(5, 10);
  balls.append(fixtures::icosphere(5, 10).moved([](const Vec3& p) { return Vec3(p + Vec3(10, 0.1, 0.2)); }));
  const Contour contour = even_contour(contoured_body(balls), 1);
  EXPECT_EQ(contour.euler_number(), 2);
  const double volume = (8.0 / 3 - 5.0 / 12) * std::numbers::pi * 1000;
  EXPECT_NEAR(enclosed_volume(contour), volume, 0.02 * volume);
}

// A hole's winding number is a half where the ball's wall was, but for its bulge.
TEST(Contour, OfABallWithHolesIsClosed) {
  fixtures::TriangleSoup ball = fixtures::icosphere(4, 10);
  for (const Vec3& gone : {Vec3(0, 0, 10), Vec3(6, -8, 0)})
    std::erase_if(ball.triangles, [&](const Cell<3>& t) {
      return (ball.points[t[0]] + ball.points[t[1]] + ball.points[t[2]] - 3 * gone).norm() < 6;
    });
  const Contour contour = even_contour(contoured_body(ball), 0.7);
  EXPECT_EQ(contour.euler_number(), 2);
  for (const Vec3& p : contour.points) EXPECT_NEAR(p.norm(), 10, 0.4);
}

TEST(Contour, OfAFinAndALooseSheetIsTheBallAlone) {
  fixtures::TriangleSoup ball = fixtures::icosphere(4, 10);
  const auto first = static_cast<std::uint32_t>(ball.points.size());
  ball.points.insert(ball.points.end(), {{0, 0, 14}, {11, 1, 0}, {13, 0, 0}, {12, 1, 3}});
  ball.triangles.push_back({ball.triangles[7][0], ball.triangles[7][1], first});
  ball.triangles.push_back({first + 1, first + 2, first + 3});
  const Contour contour = even_contour(contoured_body(ball), 0.8);
  EXPECT_EQ(contour.euler_number(), 2);
  for (const Vec3& p : contour.points) EXPECT_NEAR(p.norm(), 10, 0.1);
}

TEST(Contour, EveryThreadCountMakesTheSameBits) {
  fixtures::TriangleSoup soup = fixtures::torus_surface(10, 4, 60, 30);
  soup.triangles.erase(soup.triangles.begin() + 40, soup.triangles.begin() + 44);
  const TriangleMesh given = contoured_body(soup);
  Contour first;
  for (const int threads : {1, 2, 3, 8}) {
    const parallel::ThreadLimit limit(threads);
    const Contour made = even_contour(given, 0.8);
    if (threads == 1) first = made;
    EXPECT_EQ(made.points, first.points);
    EXPECT_EQ(made.triangles, first.triangles);
    EXPECT_EQ(made.given, first.given);
  }
}

}  // namespace
}  // namespace lumesh::surfaces
