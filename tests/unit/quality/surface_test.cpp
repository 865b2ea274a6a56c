#include "lumesh/quality/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "fixtures/meshes.hpp"

namespace lumesh::quality {
namespace {

/// The unit cubes (i, j, k) of an n^3 grid that `keep` takes, six tetrahedra each.
MixedMesh cubes(int n, const std::function<Label(int, int, int)>& label_of) {
  const fixtures::TetSoup soup = fixtures::cube_grid(n);
  MixedMesh mesh;
  mesh.points = soup.points;
  for (std::size_t t = 0; t < soup.tets.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (const std::uint32_t v : soup.tets[t]) centre += soup.points[v] / 4;
    const Label label =
        label_of(static_cast<int>(centre.x()), static_cast<int>(centre.y()), static_cast<int>(centre.z()));
    if (label == kBackground) continue;
    mesh.tetrahedra.push_back(soup.tets[t]);
    mesh.tetrahedron_labels.push_back(label);
  }
  return mesh;
}

SurfaceTopology outer_topology(const MixedMesh& mesh) {
  return analyse_surface(mesh.points, extract_surface(mesh.view()).outer());
}

TEST(Surface, CubeIsASphereWithItsAreaAndVolume) {
  const MixedMesh mesh = cubes(3, [](int, int, int) { return 1; });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_TRUE(s.closed());
  EXPECT_TRUE(s.manifold());
  ASSERT_EQ(s.components.size(), 1u);
  EXPECT_EQ(s.triangles, 108u);  // 6 sides of 9 squares of 2 triangles
  EXPECT_EQ(s.vertices, 56u);    // 64 grid points but the 8 inner ones
  EXPECT_EQ(s.components[0].euler, 2);
  EXPECT_EQ(s.genus(), 0);
  EXPECT_NEAR(s.components[0].area_mm2, 54, 1e-12);
  EXPECT_NEAR(s.components[0].enclosed_volume_mm3, 27, 1e-12);
}

TEST(Surface, RingOfCubesHasGenusOne) {
  const MixedMesh mesh = cubes(3, [](int i, int j, int k) { return k == 0 && !(i == 1 && j == 1) ? 1 : 0; });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_TRUE(s.manifold());
  ASSERT_EQ(s.components.size(), 1u);
  EXPECT_EQ(s.components[0].euler, 0);
  EXPECT_EQ(s.genus(), 1);
  const auto solids = analyse_solids(mesh.view());
  EXPECT_EQ(solids.at(0).components, 1u);
  EXPECT_EQ(solids.at(0).euler, 0);
}

TEST(Surface, HollowCubeHasTwoSurfacesAndEulerTwo) {
  const MixedMesh mesh = cubes(3, [](int i, int j, int k) { return i == 1 && j == 1 && k == 1 ? 0 : 1; });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_TRUE(s.manifold());
  ASSERT_EQ(s.components.size(), 2u);
  EXPECT_NEAR(s.components[0].enclosed_volume_mm3, 27, 1e-12);
  EXPECT_NEAR(s.components[1].enclosed_volume_mm3, -1, 1e-12);
  EXPECT_EQ(s.genus(), 0);
  const auto solids = analyse_solids(mesh.view());
  EXPECT_EQ(solids.at(0).components, 1u);
  EXPECT_EQ(solids.at(0).euler, 2);
}

TEST(Surface, TwoPiecesAreTwoComponents) {
  const MixedMesh mesh = cubes(3, [](int i, int, int) { return i == 1 ? 0 : 1; });
  EXPECT_EQ(outer_topology(mesh).components.size(), 2u);
  const auto solids = analyse_solids(mesh.view());
  EXPECT_EQ(solids.at(0).components, 2u);
  EXPECT_EQ(solids.at(0).euler, 2);
}

TEST(Surface, CubesThatTouchInAVertexAreNotManifold) {
  const MixedMesh mesh =
      cubes(2, [](int i, int j, int k) { return (i + j + k == 0 || i + j + k == 3) ? 1 : 0; });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_TRUE(s.closed());
  EXPECT_FALSE(s.manifold());
  EXPECT_EQ(s.non_manifold_edges, 0u);
  EXPECT_EQ(s.non_manifold_vertices, 1u);
  const auto solids = analyse_solids(mesh.view());
  EXPECT_EQ(solids.at(0).components, 2u);  // through faces
  EXPECT_EQ(solids.at(0).euler, 1);        // two balls that share a point
}

TEST(Surface, CubesThatTouchInAnEdgeAreNotManifold) {
  const MixedMesh mesh = cubes(2, [](int i, int j, int k) { return k == 0 && i == j ? 1 : 0; });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_FALSE(s.manifold());
  EXPECT_EQ(s.non_manifold_edges, 1u);
  EXPECT_EQ(s.genus(), -1);
}

TEST(Surface, PinchInsideOnePieceIsFound) {
  // A path of cubes whose ends touch in one corner only: every edge is fine, one vertex has two rings.
  const MixedMesh mesh = cubes(5, [](int i, int j, int k) {
    static const std::array<std::array<int, 3>, 14> path = {{{1, 1, 1},
                                                             {0, 1, 1},
                                                             {0, 1, 2},
                                                             {0, 1, 3},
                                                             {0, 1, 4},
                                                             {1, 1, 4},
                                                             {2, 1, 4},
                                                             {3, 1, 4},
                                                             {4, 1, 4},
                                                             {4, 2, 4},
                                                             {4, 2, 3},
                                                             {4, 2, 2},
                                                             {3, 2, 2},
                                                             {2, 2, 2}}};
    for (const auto& c : path)
      if (c[0] == i && c[1] == j && c[2] == k) return 1;
    return 0;
  });
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_EQ(s.components.size(), 1u);
  EXPECT_EQ(s.non_manifold_edges, 0u);
  EXPECT_EQ(s.non_manifold_vertices, 1u);  // the point (2, 2, 2)
  EXPECT_EQ(s.genus(), -1);
}

TEST(Surface, LabelsHaveClosedSurfacesOfTheirOwn) {
  const MixedMesh mesh = cubes(4, [](int i, int, int) { return i < 2 ? 1 : 2; });
  const MeshSurface surface = extract_surface(mesh.view());
  for (const Label label : {1, 2}) {
    const SurfaceTopology s = analyse_surface(mesh.points, surface.around(label));
    EXPECT_TRUE(s.manifold());
    EXPECT_NEAR(s.components.at(0).enclosed_volume_mm3, 32, 1e-12);
    EXPECT_NEAR(s.components.at(0).area_mm2, 64, 1e-12);
  }
  const SurfaceTopology outside = analyse_surface(mesh.points, surface.outer());
  EXPECT_NEAR(outside.components.at(0).area_mm2, 96, 1e-12);
  EXPECT_EQ(surface.triangles.size() - outside.triangles, 32u);  // interface: 16 squares
  const auto solids = analyse_solids(mesh.view());
  ASSERT_EQ(solids.size(), 3u);
  EXPECT_EQ(solids[0].euler, 1);
  EXPECT_EQ(solids[1].euler, 1);
  EXPECT_EQ(solids[2].label, kOutside);
  EXPECT_EQ(solids[2].components, 1u);
  EXPECT_EQ(solids[2].euler, 1);
}

TEST(Surface, OpenAndMissingTrianglesAreNoticed) {
  const MixedMesh mesh = cubes(2, [](int, int, int) { return 1; });
  std::vector<Cell<3>> triangles = extract_surface(mesh.view()).outer();
  triangles.pop_back();
  const SurfaceTopology s = analyse_surface(mesh.points, triangles);
  EXPECT_FALSE(s.closed());
  EXPECT_EQ(s.open_edges, 3u);
  EXPECT_EQ(s.genus(), -1);
}

TEST(Surface, HexahedraAndPyramidsJoinThroughTheirQuadrilaterals) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},  {0, 0, 1},
                 {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {.5, .5, 2}};
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hexahedron_labels = {1};
  mesh.pyramids = {{4, 5, 6, 7, 8}};
  mesh.pyramid_labels = {1};
  const SurfaceTopology s = outer_topology(mesh);
  EXPECT_TRUE(s.manifold());
  EXPECT_EQ(s.triangles, 14u);  // five quadrilaterals and four triangles
  EXPECT_EQ(s.genus(), 0);
  const auto solids = analyse_solids(mesh.view());
  EXPECT_EQ(solids.at(0).components, 1u);
  EXPECT_EQ(solids.at(0).euler, 1);
}

TEST(Surface, PatchesKnowAreaNormalAndFlatness) {
  MixedMesh mesh = cubes(2, [](int, int, int) { return 1; });
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}}, {"inlet_1", PatchKind::kOpening, {1, 0}}};
  const MeshSurface unnamed = extract_surface(mesh.view());
  for (const Cell<3>& t : unnamed.triangles) {
    const bool top = mesh.points[t[0]].z() == 2 && mesh.points[t[1]].z() == 2 && mesh.points[t[2]].z() == 2;
    mesh.triangles.push_back(t);
    mesh.triangle_patches.push_back(top ? 1 : 0);
  }
  mesh.points[1 + 3 * (1 + 3 * 2)].z() += 0.09;  // the middle of the top
  const auto patches = summarise_patches(mesh.view(), extract_surface(mesh.view()));
  ASSERT_EQ(patches.size(), 2u);
  EXPECT_EQ(patches[1].name, "inlet_1");
  EXPECT_EQ(patches[1].faces, 8u);
  EXPECT_NEAR(patches[0].area_mm2, 20, 1e-12);
  EXPECT_NEAR(patches[0].smallest_angle_deg, 45, 1e-9);
  EXPECT_TRUE(patches[1].normal.isApprox(Vec3(0, 0, 1)));
  EXPECT_NEAR(patches[1].flatness_mm, 0.08, 1e-9);  // 9 vertices: their mean lies 0.01 up
}

}  // namespace
}  // namespace lumesh::quality
