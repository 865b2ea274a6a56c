#include "lumesh/quality/faults.hpp"

#include <gtest/gtest.h>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {
namespace {

/// One tetrahedron at `base`, with its four faces on the wall.
void add_tetrahedron(MixedMesh& mesh, const Vec3& base) {
  const auto v = static_cast<std::uint32_t>(mesh.points.size());
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    mesh.points.emplace_back(base + corner);
  mesh.tetrahedra.push_back({v, v + 1, v + 2, v + 3});
  mesh.tetrahedron_labels.push_back(1);
  for (const Cell<3>& face : {Cell<3>{1, 2, 3}, Cell<3>{0, 3, 2}, Cell<3>{0, 1, 3}, Cell<3>{0, 2, 1}}) {
    mesh.triangles.push_back({face[0] + v, face[1] + v, face[2] + v});
    mesh.triangle_patches.push_back(0);
  }
}

MixedMesh wall_only() {
  MixedMesh mesh;
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}}, {"interface_1_2", PatchKind::kInterface, {1, 2}}};
  return mesh;
}

TEST(Faults, NoneInWhatFillsItsOutsideOnce) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  add_tetrahedron(mesh, {2, 0, 0});
  EXPECT_TRUE(find_faults(mesh.view()).empty());
}

TEST(Faults, CellsThatOverlapAreFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  add_tetrahedron(mesh, {0.1, 0.1, 0.1});
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("crosses or touches itself"), std::string::npos) << faults[0];
}

TEST(Faults, ATurnedCellIsFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  add_tetrahedron(mesh, {5, 6, 7});
  mesh.points[7].z() -= 2;
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].find("1 cells are flat or turned inside out, one at (6, 6, 7)"), std::string::npos)
      << faults[0];
}

TEST(Faults, AHoleInTheOutsideIsFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  mesh.triangle_patches[0] = 1;  // Called an interface, with nothing behind it.
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_NE(faults[0].find("3 edges of the outside"), std::string::npos) << faults[0];
  EXPECT_NE(faults[1].find("fill 0.166666667 mm3 but the outside encloses"), std::string::npos) << faults[1];
}

TEST(Faults, AGapWithinIsFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  mesh.tetrahedra.clear();
  mesh.tetrahedron_labels.clear();
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("gaps or overlaps"), std::string::npos) << faults[0];
}

TEST(Faults, HalvesOfQuadrilateralsCloseTheOutsideOfAPrism) {
  MixedMesh mesh = wall_only();
  mesh.points = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
  mesh.prisms = {{0, 1, 2, 3, 4, 5}};
  mesh.prism_labels = {1};
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
  mesh.triangle_patches = {0, 0};
  mesh.quadrilaterals = {{0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
  mesh.quadrilateral_patches = {0, 0, 0};
  EXPECT_TRUE(find_faults(mesh.view()).empty());
  mesh.points[4].z() = -1;  // Through the bottom.
  EXPECT_FALSE(find_faults(mesh.view()).empty());
}

}  // namespace
}  // namespace lumesh::quality
