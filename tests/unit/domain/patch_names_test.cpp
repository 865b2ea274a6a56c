// Names of patches of a domain.
#include "lumesh/domain/patch_names.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "fixtures/analytic_domain.hpp"
#include "lumesh/domain/walls_in_planes.hpp"

namespace lumesh {
namespace {

/// A tube of radius 2 along z, cut off at z = 0.
fixtures::AnalyticDomain tube_with_end() {
  fixtures::AnalyticDomainOptions options;
  options.bounds_mm = Box3(Vec3(-3, -3, -4), Vec3(3, 3, 1));
  options.resolution_mm = 0.25;
  options.cut_planes = {{Vec3::Zero(), Vec3::UnitZ()}};
  return {{{1, fixtures::cylinder_shape(Vec3::Zero(), Vec3::UnitZ(), 2)}}, options};
}

/// A tube of radius 2 with its end at z = 0: a square of two triangles is the opening; another triangle that
/// lies in the plane, and meets it in a corner, is of the wall if it is small.
TEST(PatchNames, SplintersBesideAnOpeningAreWall) {
  const fixtures::AnalyticDomain domain = tube_with_end();
  const Material beyond = domain.material_beyond(0);
  const std::vector<BoundaryTriangle> boundary = {
      {{0, 1, 2}, 1, beyond}, {{0, 2, 3}, 1, beyond}, {{2, 4, 5}, 1, beyond}, {{0, 1, 6}, 1, 0}};
  for (const bool is_small : {true, false}) {
    const std::vector<Vec3> points = {{-1.4, -1.4, 0},
                                      {1.4, -1.4, 0},
                                      {1.4, 1.4, 0},
                                      {-1.4, 1.4, 0},
                                      {is_small ? 1.4 : 2.1, is_small ? 1.5 : 0.4, 0},
                                      {2, 2, 0},
                                      {0, -1.5, -2}};
    const PatchAssignment named = name_patches(boundary, points, domain);
    const auto name_of = [&](std::size_t t) {
      return named.patches[static_cast<std::size_t>(named.of_triangle[t])].name;
    };
    EXPECT_EQ(name_of(0), "inlet_1");
    EXPECT_EQ(name_of(1), "inlet_1");
    EXPECT_EQ(name_of(3), "wall");
    EXPECT_EQ(name_of(2), is_small ? "wall" : "inlet_1");
  }
}

/// Two triangles, a square with a corner at (x, y, z).
void add_square(const Vec3& corner, double edge, std::vector<Vec3>& points, std::vector<Cell<3>>& triangles) {
  const auto first = static_cast<std::uint32_t>(points.size());
  for (const auto& [right, up] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    points.push_back(corner + edge * Vec3(right, up, 0));
  triangles.insert(triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
}

TEST(PatchNames, WhatLiesWhereTheDomainHasNoOpeningIsWall) {
  const fixtures::AnalyticDomain domain = tube_with_end();
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  add_square({7, -1, 0}, 2, points, triangles);
  add_square({-1, -1, 0}, 2, points, triangles);
  std::vector<BoundaryTriangle> boundary;
  for (const Cell<3>& corners : triangles) boundary.push_back({corners, 1, domain.material_beyond(0)});
  const PatchAssignment named = name_patches(boundary, points, domain);
  const auto kind_of = [&](std::size_t t) {
    return named.patches[static_cast<std::size_t>(named.of_triangle[t])].kind;
  };
  EXPECT_EQ(kind_of(0), PatchKind::kWall);
  EXPECT_EQ(kind_of(1), PatchKind::kWall);
  EXPECT_EQ(kind_of(2), PatchKind::kOpening);
}

TEST(WallsInPlanes, AreThoseLargerThanAVoxelsFace) {
  const fixtures::AnalyticDomain domain = tube_with_end();
  const double edge = 1.5 * domain.resolution_mm();  // 2.25 voxel faces.
  MixedMesh mesh;
  add_square({7, 2, 0}, edge, mesh.points, mesh.triangles);
  add_square({3, 9, 0}, 0.6 * edge, mesh.points, mesh.triangles);                          // 0.8
  add_square({-8, 2, -0.01 * domain.resolution_mm()}, edge, mesh.points, mesh.triangles);  // Off the plane.
  add_square({-1, -1, 0}, edge, mesh.points, mesh.triangles);                              // An opening.
  mesh.triangle_patches = {0, 0, 0, 0, 0, 0, 1, 1};
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, kBackground}},
                       {"inlet_1", PatchKind::kOpening, {1, kBackground}}};
  const std::vector<WallInPlane> walls = walls_in_planes(mesh.view(), domain);
  ASSERT_EQ(walls.size(), 1U);
  EXPECT_NEAR(walls[0].area_mm2, edge * edge, 1e-9);
  EXPECT_NEAR((walls[0].centre_mm - Vec3(7 + 0.5 * edge, 2 + 0.5 * edge, 0)).norm(), 0, 1e-9);
  EXPECT_EQ(walls[0].patch, "wall");
  EXPECT_EQ(doubts_about(walls).size(), 1U);
}

}  // namespace
}  // namespace lumesh
