#include "lumesh/operators/crossings.hpp"

#include <gtest/gtest.h>

#include "fixtures/meshes.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/creases.hpp"

namespace lumesh::operators {
namespace {

/// Two cubes of edge 4, in 4 x 4 x 4 x 6 tetrahedra each, whose faces z = 4 and z = 4 + gap look at each
/// other.
fixtures::TetSoup two_cubes(double gap) {
  fixtures::TetSoup soup = fixtures::cube_grid(4);
  const fixtures::TetSoup one = soup;
  const auto count = static_cast<std::uint32_t>(one.points.size());
  for (const Vec3& x : one.points) soup.points.emplace_back(x + Vec3(0.3, 0.4, 4 + gap));
  for (const Cell<4>& t : one.tets)
    soup.tets.push_back({t[0] + count, t[1] + count, t[2] + count, t[3] + count});
  soup.labels.resize(soup.tets.size(), 1);
  return soup;
}

bool anything(std::size_t /*tet*/, const std::array<Vec3, 4>& /*before*/,
              const std::array<Vec3, 4>& /*after*/) {
  return true;
}

/// Pushes the middle of the lower cube's top up into the upper one.
std::size_t push_up(std::vector<Vec3>& points, double by) {
  for (std::size_t v = 0; v < points.size() / 2; ++v)
    if ((points[v] - Vec3(2, 2, 4)).norm() < 1e-9) {
      points[v].z() += by;
      return v;
    }
  return points.size();
}

TEST(SheetCrossings, AreUndoneWhereTheyAreAndNowhereElse) {
  const TetMesh mesh = two_cubes(0.2).build();
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<Cell<3>> outside = outside_of(faces);
  const std::vector<Vec3> before(mesh.points().begin(), mesh.points().end());
  std::vector<Vec3> points = before;
  const std::size_t pushed = push_up(points, 0.3);
  ASSERT_LT(pushed, points.size());
  std::size_t far = 0;
  while ((before[far] - Vec3(0, 0, 0)).norm() > 1e-9) ++far;
  points[far] -= Vec3(0.1, 0.1, 0.1);
  ASSERT_FALSE(find_self_crossings(points, outside).empty());
  const auto keeps_corner = [&](std::size_t, const std::array<Vec3, 4>& was, const std::array<Vec3, 4>& is) {
    return was == is || std::none_of(was.begin(), was.end(), [](const Vec3& x) { return x.norm() < 1e-9; });
  };
  const UndoReport report = undo_crossings(points, mesh.tets(), outside, before, keeps_corner);
  EXPECT_EQ(report.crossings, 0u);
  EXPECT_EQ(report.put_back, 1u);
  EXPECT_TRUE(find_self_crossings(points, outside).empty());
  EXPECT_EQ(points[pushed], before[pushed]);
  EXPECT_NE(points[far], before[far]) << "what does not cross stays moved";
}

TEST(SheetCrossings, ThatWereThereBeforeAreCounted) {
  const TetMesh mesh = two_cubes(-0.1).build();
  const std::vector<Cell<3>> outside = outside_of(mesh.boundary_faces());
  const std::vector<Vec3> before(mesh.points().begin(), mesh.points().end());
  std::vector<Vec3> points = before;
  EXPECT_GT(undo_crossings(points, mesh.tets(), outside, before, anything).crossings, 0u);
  EXPECT_EQ(points, before);
}

PatchShapes curved(const TetMesh& mesh) {
  PatchShapes shapes = all_frozen(mesh);
  for (PatchShape& shape : shapes) shape.freedom = PatchFreedom::kCurved;
  return shapes;
}

TEST(SheetCrossings, WhatIsFrozenStays) {
  TetMesh mesh = two_cubes(-0.1).build();
  const std::vector<Vec3> before(mesh.points().begin(), mesh.points().end());
  EXPECT_GT(draw_apart(mesh, all_frozen(mesh)), 0u);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), mesh.points().begin()));
}

TEST(SheetCrossings, SheetsAreDrawnApart) {
  TetMesh mesh = two_cubes(-0.1).build();
  ASSERT_FALSE(validate(mesh).ok());
  EXPECT_EQ(draw_apart(mesh, curved(mesh)), 0u);
  const ValidationReport report = validate(mesh);
  EXPECT_TRUE(report.ok()) << report.text();
}

/// The cubes' sides are planes, their edges creases: what small facets between creases of a wall are.
TEST(SheetCrossings, FlatWallsAreDrawnApartButNotOpenings) {
  for (const PatchKind kind : {PatchKind::kWall, PatchKind::kOpening}) {
    TetMesh mesh = two_cubes(-0.1).build();
    mesh.info().patches[0].kind = kind;
    static_cast<void>(cut_patches_at_creases(mesh, 40));
    EXPECT_EQ(draw_apart(mesh, planes_where_flat(mesh)) == 0, kind == PatchKind::kWall);
    EXPECT_EQ(validate(mesh).ok(), kind == PatchKind::kWall);
  }
}

TEST(SheetCrossings, NothingMovesWhereNothingCrosses) {
  TetMesh mesh = two_cubes(0.1).build();
  const std::vector<Vec3> before(mesh.points().begin(), mesh.points().end());
  EXPECT_EQ(draw_apart(mesh, curved(mesh)), 0u);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), mesh.points().begin()));
}

}  // namespace
}  // namespace lumesh::operators
