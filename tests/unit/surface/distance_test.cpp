// Farthest points of triangles of which only a part counts.
#include "lumesh/surface/distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lumesh::surfaces {
namespace {

/// A square of the side 10 in two triangles, which rises by `slope` along x.
TriangleMesh square(double height, double slope) {
  TriangleMesh mesh;
  for (const double y : {0.0, 10.0})
    for (const double x : {0.0, 10.0}) mesh.points.emplace_back(x, y, height + slope * x);
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  mesh.patches = {1, 1};
  return mesh;
}

TEST(FarthestFrom, FewPointsAreAskedForWhereRadiiTellThatOthersDoNotCount) {
  const TriangleMesh flat = square(0, 0), steep = square(2, -0.1);
  const TriangleTree other(steep.points, steep.triangles);
  std::size_t asked = 0;
  const auto farthest = [&](bool has_radii) {
    asked = 0;
    // The distance falls along x; points before x = 9 do not count.
    return farthest_from(flat, other, 0.2, nullptr, [&](const Vec3& p, std::size_t) {
      ++asked;
      if (p.x() >= 9) return -1.0;
      return has_radii ? 9 - p.x() : 0.0;
    });
  };
  const FarthestPoint slowly = farthest(false);
  const std::size_t all = asked;
  const FarthestPoint quickly = farthest(true);
  EXPECT_NEAR(slowly.distance_mm, 1.1 * std::cos(std::atan(0.1)), 0.02);
  EXPECT_EQ(quickly.distance_mm, slowly.distance_mm);
  EXPECT_EQ(quickly.place_mm, slowly.place_mm);
  EXPECT_LT(20 * asked, all);
}

}  // namespace
}  // namespace lumesh::surfaces
