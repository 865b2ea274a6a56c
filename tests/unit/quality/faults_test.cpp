#include "lumesh/quality/faults.hpp"

#include <gtest/gtest.h>

#include "fixtures/meshes.hpp"
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
  EXPECT_NE(faults[0].find("1 cell is flat or turned inside out, at (6, 6, 7)"), std::string::npos)
      << faults[0];
  const std::vector<MeshFault> placed = find_placed_faults(mesh.view());
  ASSERT_EQ(placed.size(), faults.size());
  EXPECT_EQ(placed[0].text, faults[0]);
  EXPECT_EQ(placed[0].place, Vec3(6, 6, 7));
}

TEST(Faults, PointsBeyondEveryBodyAreFound) {
  for (const double far : {1e18, -1e300}) {
    MixedMesh mesh = wall_only();
    add_tetrahedron(mesh, {0, 0, 0});
    mesh.points[3].z() = far;
    mesh.points[0].z() = far > 0 ? 0 : 1;
    const std::vector<std::string> faults = find_faults(mesh.view());
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0].find("point 3 lies beyond 1e+12, at (0, 0, "), 0u) << faults[0];
  }
}

TEST(Faults, CellsThatShareAFaceOnOneSideAreFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  mesh.points.emplace_back(0.2, 0.2, 0.9);
  mesh.tetrahedra.push_back({0, 1, 2, 4});
  mesh.tetrahedron_labels.push_back(1);
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].find("edges of the outside do not have one face on each side"), std::string::npos)
      << faults[0];
}

TEST(Faults, AnOverlapThatAGapMakesUpForIsFound) {
  const fixtures::TetSoup cube = fixtures::cube_of_6();
  MixedMesh mesh = wall_only();
  mesh.points = cube.points;
  mesh.tetrahedra = cube.tets;
  mesh.tetrahedron_labels = cube.labels;
  EXPECT_TRUE(find_faults(mesh.view()).empty());
  mesh.tetrahedra[1] = mesh.tetrahedra[0];
  EXPECT_FALSE(find_faults(mesh.view()).empty());
}

TEST(Faults, APieceWithinAnotherIsFound) {
  MixedMesh mesh = wall_only();
  add_tetrahedron(mesh, {0, 0, 0});
  add_tetrahedron(mesh, {0, 0, 0});
  for (std::size_t v = 4; v < 8; ++v) mesh.points[v] = Vec3(0.1, 0.1, 0.1) + 0.2 * mesh.points[v];
  const std::vector<std::string> faults = find_faults(mesh.view());
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("1 piece of the mesh lies within another, at (0.1, 0.1, 0.1)"), std::string::npos)
      << faults[0];
}

/// Readers take interfaces for walls where names do not say otherwise.
TEST(Faults, PatchesDoNotMatter) {
  const fixtures::TetSoup soup = fixtures::two_label_block(4);
  MixedMesh mesh = wall_only();
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  EXPECT_TRUE(find_faults(mesh.view()).empty()) << "without any faces";
  const TetMesh built = soup.build();
  const BoundaryFaces faces = built.boundary_faces();
  mesh.triangles = faces.triangles;
  mesh.triangle_patches.assign(faces.triangles.size(), 0);
  EXPECT_TRUE(find_faults(mesh.view()).empty()) << "with the interface as a wall";
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
