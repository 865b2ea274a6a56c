// The outside of a mesh: which faces it leaves out, and what it says of them.
#include "lumesh/mesh/outer_faces.hpp"

#include <gtest/gtest.h>

namespace lumesh {
namespace {

/// Two tetrahedra on both sides of a triangle, and two hexahedra on both sides of a quadrilateral.
MixedMesh two_pairs() {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.tetrahedron_labels = {1, 2};
  for (int z = 0; z < 3; ++z)
    for (const Vec3& p : {Vec3(5, 0, 0), Vec3(6, 0, 0), Vec3(6, 1, 0), Vec3(5, 1, 0)})
      mesh.points.emplace_back(p + z * Vec3::UnitZ());
  mesh.hexahedra = {{5, 6, 7, 8, 9, 10, 11, 12}, {9, 10, 11, 12, 13, 14, 15, 16}};
  mesh.hexahedron_labels = {1, 2};
  mesh.info.patches = {{"wall"}, {"sheet"}, {"loose"}};
  return mesh;
}

TEST(OuterFaces, LeaveOutWhatLiesBetweenTwoCellsWhicheverWayItIsTurned) {
  MixedMesh mesh = two_pairs();
  mesh.triangles = {{0, 1, 3}, {2, 0, 1}, {1, 0, 2}, {0, 1, 5}};  // Of one cell, between, between, of none.
  mesh.triangle_patches = {0, 1, 1, 2};
  mesh.quadrilaterals = {{5, 8, 7, 6}, {10, 11, 12, 9}, {9, 12, 11, 10}, {13, 14, 15, 16}};
  mesh.quadrilateral_patches = {0, 1, 1, 0};
  const OuterFaces outside(mesh.view());
  const MeshView view = outside.view();
  EXPECT_EQ(std::vector(view.triangles.begin(), view.triangles.end()),
            (std::vector<Cell<3>>{{0, 1, 3}, {0, 1, 5}}));
  EXPECT_EQ(std::vector(view.triangle_patches.begin(), view.triangle_patches.end()), (std::vector{0, 2}));
  EXPECT_EQ(std::vector(view.quadrilaterals.begin(), view.quadrilaterals.end()),
            (std::vector<Cell<4>>{{5, 8, 7, 6}, {13, 14, 15, 16}}));
  EXPECT_EQ(view.cell_count(), 0U);
  EXPECT_EQ(outside.left_out_text(), "4 faces between cells (sheet)");
}

TEST(OuterFaces, AreAllFacesWhereThereAreNoCells) {
  MixedMesh mesh;
  mesh.points = two_pairs().points;
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  mesh.triangle_patches = {0, 0};
  const OuterFaces outside(mesh.view());
  EXPECT_EQ(outside.view().triangles.size(), 2U);
  EXPECT_EQ(outside.left_out_text(), "");
}

TEST(OuterFaces, AreNoneWhereAMeshHasNoFaces) {
  const MixedMesh mesh = two_pairs();
  const OuterFaces outside(mesh.view());
  EXPECT_TRUE(outside.view().triangles.empty());
  EXPECT_EQ(outside.left_out_text(), "");
}

}  // namespace
}  // namespace lumesh
