#include "lumesh/domain/surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "fixtures/curved_meshes.hpp"

namespace lumesh {
namespace {

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

TEST(CylinderSurface, GivesTheNearestPointAndTheNormalOutOfTheMesh) {
  const Vec3 axis = Vec3(1, 2, 2) / 3, on_axis(4, -1, 2);
  const CylinderSurface inside(on_axis, axis, 1.5, 1), outside(on_axis, axis, 1.5, -1);
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) {
    const Vec3 query = on_axis + 3 * random_direction(random);
    const SurfacePoint found = inside.closest(query);
    const Vec3 arm = found.point - on_axis;
    EXPECT_NEAR(arm.cross(axis).norm(), 1.5, 1e-14);
    EXPECT_NEAR(arm.dot(axis), (query - on_axis).dot(axis), 1e-14);   // Straight across the axis,
    EXPECT_GT((query - on_axis).dot(arm - arm.dot(axis) * axis), 0);  // to the side it came from.
    EXPECT_NEAR((arm - arm.dot(axis) * axis - 1.5 * found.normal).norm(), 0, 1e-14);
    EXPECT_EQ(outside.closest(query).normal, -found.normal);
  }
}

TEST(MeshSurface, OfAnIcosphereIsMuchNearerToTheSphereThanItsTriangles) {
  for (const int levels : {1, 2, 3}) {
    const fixtures::Icosphere sphere(levels);
    const MeshSurface surface(sphere.points, sphere.triangles, {});
    std::mt19937 random(3);
    double worst = 0, worst_normal = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 direction = random_direction(random);
      const SurfacePoint found = surface.closest(0.97 * direction);
      worst = std::max(worst, std::abs(found.point.norm() - 1));
      worst_normal = std::max(worst_normal, (found.normal - found.point.normalized()).norm());
    }
    double deepest = 0;  // Of the triangles, in their middles.
    for (const auto& [a, b, c] : sphere.triangles)
      deepest = std::max(deepest, 1 - (sphere.points[a] + sphere.points[b] + sphere.points[c]).norm() / 3);
    EXPECT_LT(worst, 0.1 * deepest) << levels;
    EXPECT_LT(worst_normal, 2 * deepest) << levels;
  }
}

TEST(MeshSurface, OfAPlaneIsThePlane) {
  const std::vector<Vec3> points = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  const MeshSurface surface(points, std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}, {});
  const SurfacePoint found = surface.closest({1.3, 0.4, 0.7});
  EXPECT_NEAR((found.point - Vec3(1.3, 0.4, 0)).norm(), 0, 1e-14);
  EXPECT_NEAR((found.normal - Vec3(0, 0, 1)).norm(), 0, 1e-14);
}

TEST(MeshCurve, FindsTheNearestPointOfAQuarterCircle) {
  // Two Hermite pieces of a quarter circle; the handle of a cubic arc is 4/3 tan(angle / 4).
  const double quarter = std::numbers::pi / 4, handle = 4.0 / 3 * std::tan(quarter / 4);
  std::vector<CurvePiece> pieces;
  for (int i = 0; i < 2; ++i) {
    const double from = i * quarter, to = from + quarter;
    const Vec3 a(std::cos(from), std::sin(from), 0), b(std::cos(to), std::sin(to), 0);
    pieces.push_back({{a, a + handle * Vec3(-a[1], a[0], 0), b - handle * Vec3(-b[1], b[0], 0), b}});
  }
  const MeshCurve curve(pieces);
  for (double angle = 0.05; angle < 1.5; angle += 0.1) {
    const Vec3 on(std::cos(angle), std::sin(angle), 0);
    const CurvePoint found = curve.closest(0.9 * on + Vec3(0, 0, 0.2));
    EXPECT_NEAR((found.point - on).norm(), 0, 2e-5);
    EXPECT_NEAR(found.tangent.dot(Vec3(-on[1], on[0], 0)), 1, 1e-6);
  }
}

}  // namespace
}  // namespace lumesh
