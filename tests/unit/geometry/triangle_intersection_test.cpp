#include "lumesh/geometry/triangle_intersection.hpp"

#include <gtest/gtest.h>

namespace lumesh {
namespace {

const std::array<Vec3, 3> kFlat = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};

TEST(TrianglesMeet, WhereOneCutsThroughTheOther) {
  EXPECT_TRUE(triangles_meet(kFlat, {Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(9, 9, 1)}));
  EXPECT_TRUE(triangles_meet({Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(9, 9, 1)}, kFlat));
}

TEST(TrianglesMeet, WhereTheyTouchInAPointOrAlongAnEdge) {
  EXPECT_TRUE(triangles_meet(kFlat, {Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(2, 1, 1)}));
  EXPECT_TRUE(triangles_meet(kFlat, {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 0, 4)}));
}

TEST(TrianglesMeet, NotBesideOrAboveEachOther) {
  EXPECT_FALSE(triangles_meet(kFlat, {Vec3(0, 0, 1e-12), Vec3(4, 0, 1e-12), Vec3(0, 4, 1e-12)}));
  EXPECT_FALSE(triangles_meet(kFlat, {Vec3(3, 3, -1), Vec3(3, 3, 1), Vec3(9, 9, 1)}));
  EXPECT_FALSE(triangles_meet(kFlat, {Vec3(1, 1, 0), Vec3(2, 1, 0), Vec3(1, 2, 0)}));  // In one plane.
}

}  // namespace
}  // namespace lumesh
