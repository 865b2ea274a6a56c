// Merging of tetrahedra into hexahedra and pyramids, against counts worked out by hand.
#include "../src/lattice/hexahedra.hpp"

#include <gtest/gtest.h>

#include "lattice_blocks.hpp"
#include "lumesh/parallel/loops.hpp"
#include "measures.hpp"

namespace lumesh {
namespace {

const Mat3 kTurned =
    (Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()) * Eigen::AngleAxisd(1.1, Vec3::UnitX()))
        .toRotationMatrix();

/// Five cubes along each axis with an edge of 2 mm.
MixedMesh block(const Mat3& axes) {
  return test::mesh_of(test::lattice_block({5, 5, 5}, 4), axes, 0.25);
}

TEST(Hexahedra, ABlockBecomesHexahedraAroundItsInnerCorners) {
  // 64 inner cube corners are regular and only 27 cube centres. 4^3 hexahedra leave 6 * 16 faces for
  // pyramids. Volumes in units of a cube: 1200 tetrahedra / 12 = 64 + 96 / 6 + 240 / 12.
  for (const Mat3& axes : {Mat3(Mat3::Identity()), kTurned}) {
    for (const Mat3& told : {axes, Mat3(axes * Vec3(1, 1, -1).asDiagonal())}) {
      MixedMesh mesh = block(axes);
      ASSERT_EQ(mesh.tetrahedra.size(), 1200U);
      const std::size_t points = mesh.points.size();
      const std::size_t triangles = mesh.triangles.size();
      merge_hexahedra(mesh, told);
      EXPECT_EQ(mesh.hexahedra.size(), 64U);
      EXPECT_EQ(mesh.pyramids.size(), 96U);
      EXPECT_EQ(mesh.tetrahedra.size(), 240U);
      EXPECT_EQ(mesh.points.size(), points - 64);
      EXPECT_EQ(mesh.triangles.size(), triangles);
      test::expect_conforming(mesh);
      for (const auto& h : mesh.hexahedra) EXPECT_NEAR(test::cell_volume(mesh, h), 8, 1e-9);
      for (const auto& p : mesh.pyramids) EXPECT_NEAR(test::cell_volume(mesh, p), 8.0 / 6, 1e-9);
      EXPECT_NEAR(test::label_volumes(mesh)[1], 800, 1e-8);
      EXPECT_EQ(mesh.tetrahedron_labels.size(), mesh.tetrahedra.size());
      EXPECT_EQ(mesh.pyramid_labels, std::vector<Label>(96, 1));
      EXPECT_EQ(mesh.hexahedron_labels, std::vector<Label>(64, 1));
    }
  }
}

TEST(Hexahedra, CellsDoNotCrossTheInterfaceOfTwoLabels) {
  MixedMesh mesh = block(Mat3::Identity());
  std::map<Label, double> before;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Vec3 centroid = Vec3::Zero();
    for (const std::uint32_t v : mesh.tetrahedra[t]) centroid += 0.25 * mesh.points[v];
    mesh.tetrahedron_labels[t] = centroid.x() < 5 ? 7 : 8;
  }
  before = test::label_volumes(mesh);
  merge_hexahedra(mesh, Mat3::Identity());
  EXPECT_GT(mesh.hexahedra.size(), 10U);
  test::expect_conforming(mesh);
  auto after = test::label_volumes(mesh);
  ASSERT_EQ(after.size(), 2U);
  for (const Label label : {7, 8}) EXPECT_NEAR(after[label], before[label], 1e-9);
  for (std::size_t h = 0; h < mesh.hexahedra.size(); ++h) {
    // By symmetry no cube of either label can reach beyond the middle.
    const double side = mesh.hexahedron_labels[h] == 7 ? -1 : 1;
    for (const std::uint32_t v : mesh.hexahedra[h]) EXPECT_GE(side * (mesh.points[v].x() - 5), 0);
  }
}

TEST(Hexahedra, StarsWithAMovedVertexStayTetrahedra) {
  MixedMesh mesh = block(Mat3::Identity());
  // An inner corner: itself, its 6 neighbours along the axes and the 8 centres around it no longer are
  // regular.
  const Vec3 moved(4, 4, 4);
  for (Vec3& p : mesh.points) {
    if (p == moved) p.x() += 0.01;
  }
  merge_hexahedra(mesh, Mat3::Identity());
  test::expect_conforming(mesh);
  EXPECT_NEAR(test::label_volumes(mesh)[1], 800, 1e-8);
  EXPECT_EQ(mesh.hexahedra.size(), 64U - 7);
  for (const auto& h : mesh.hexahedra) EXPECT_NEAR(test::cell_volume(mesh, h), 8, 1e-9);
}

TEST(Hexahedra, AMeshWithoutARegularStarIsLeftAlone) {
  MixedMesh mesh = test::mesh_of(test::lattice_block({2, 2, 1}, 4), Mat3::Identity(), 0.25);
  const MixedMesh before = mesh;
  merge_hexahedra(mesh, Mat3::Identity());
  EXPECT_TRUE(mesh.hexahedra.empty());
  EXPECT_TRUE(mesh.pyramids.empty());
  EXPECT_EQ(mesh.tetrahedra, before.tetrahedra);
  EXPECT_EQ(mesh.points, before.points);
}

TEST(Hexahedra, EveryThreadCountGivesTheSameCells) {
  std::vector<MixedMesh> results;
  for (const int threads : {1, 2, 5}) {
    const parallel::ThreadLimit limit(threads);
    results.push_back(test::mesh_of(test::lattice_block({13, 12, 11}, 4), kTurned, 0.25));
    merge_hexahedra(results.back(), kTurned);
  }
  EXPECT_GT(results[0].hexahedra.size(), 500U);
  for (const MixedMesh& m : results) {
    EXPECT_EQ(m.hexahedra, results[0].hexahedra);
    EXPECT_EQ(m.pyramids, results[0].pyramids);
    EXPECT_EQ(m.tetrahedra, results[0].tetrahedra);
    EXPECT_EQ(m.points, results[0].points);
  }
}

}  // namespace
}  // namespace lumesh
