#include "lumesh/quality/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fixtures/meshes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {
namespace {

MixedMesh to_mixed(const fixtures::TetSoup& soup) {
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  return mesh;
}

TEST(Statistics, RegularTetrahedronHasTheTextbookValues) {
  MixedMesh mesh;
  mesh.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.tetrahedron_labels = {7};
  const auto is_positive = [&] {
    return (mesh.points[1] - mesh.points[0])
               .cross(mesh.points[2] - mesh.points[0])
               .dot(mesh.points[3] - mesh.points[0]) > 0;
  };
  if (!is_positive()) std::swap(mesh.tetrahedra[0][2], mesh.tetrahedra[0][3]);
  const MeshStatistics s = measure(mesh.view());
  EXPECT_NEAR(s.tetrahedra.smallest_dihedral_deg.value, 70.528779, 1e-5);
  EXPECT_NEAR(s.tetrahedra.largest_dihedral_deg.value, 70.528779, 1e-5);
  EXPECT_NEAR(s.tetrahedra.smallest_mean_ratio.value, 1, 1e-12);
  EXPECT_NEAR(s.tetrahedra.mean_aspect, 1, 1e-12);
  EXPECT_NEAR(s.tetrahedra.mean_edge_mm, std::sqrt(8.0), 1e-12);
  ASSERT_EQ(s.labels.size(), 1u);
  EXPECT_EQ(s.labels[0].label, 7);
  EXPECT_NEAR(s.labels[0].volume_mm3, 8.0 / 3, 1e-12);
  EXPECT_EQ(s.tetrahedra.dihedral_deg.counts[70], 6u);
}

TEST(Statistics, CubeOfFiveHasItsKnownAnglesAndVolume) {
  // Four corners with three right angles and three of 54.7356 degrees, and a regular tetrahedron in the
  // middle.
  const MixedMesh mesh = to_mixed(fixtures::cube_of_5(3));
  const MeshStatistics s = measure(mesh.view());
  EXPECT_EQ(s.vertices, 8u);
  EXPECT_NEAR(s.tetrahedra.smallest_dihedral_deg.value, 54.735610, 1e-5);
  EXPECT_NEAR(s.tetrahedra.largest_dihedral_deg.value, 90, 1e-9);
  EXPECT_EQ(s.tetrahedra.dihedral_deg.counts[54], 12u);
  EXPECT_EQ(s.tetrahedra.dihedral_deg.counts[70], 6u);
  EXPECT_EQ(s.tetrahedra.dihedral_deg.counts[89] + s.tetrahedra.dihedral_deg.counts[90], 12u);
  EXPECT_NEAR(s.labels.at(0).volume_mm3, 1, 1e-12);
  EXPECT_EQ(s.inverted_cells, 0u);
}

TEST(Statistics, HistogramsHoldEveryAngleAndElementOnce) {
  const MixedMesh mesh = to_mixed(fixtures::bcc_block(6));
  const MeshStatistics s = measure(mesh.view());
  EXPECT_EQ(s.tetrahedra.count, mesh.tetrahedra.size());
  EXPECT_EQ(s.tetrahedra.dihedral_deg.total(), 6 * mesh.tetrahedra.size());
  EXPECT_EQ(s.tetrahedra.mean_ratio.total(), mesh.tetrahedra.size());
  // The tetrahedron of the body-centred lattice has two angles of 90 and four of 60 degrees.
  EXPECT_NEAR(s.tetrahedra.smallest_dihedral_deg.value, 60, 1e-9);
  EXPECT_NEAR(s.tetrahedra.largest_dihedral_deg.value, 90, 1e-9);
}

TEST(Statistics, FlatAndInvertedTetrahedraAreCountedAndPlaced) {
  MixedMesh mesh = to_mixed(fixtures::cube_of_6());
  std::swap(mesh.tetrahedra[2][0], mesh.tetrahedra[2][1]);  // inverted
  mesh.points.push_back({0.5, 0.5, 10});
  mesh.points.push_back({1.5, 0.5, 10});
  mesh.points.push_back({0.5, 1.5, 10});
  mesh.points.push_back({1.5, 1.5, 10});
  mesh.tetrahedra.push_back({8, 9, 10, 11});  // flat, in the plane z = 10
  mesh.tetrahedron_labels.push_back(1);
  const MeshStatistics s = measure(mesh.view());
  EXPECT_EQ(s.tetrahedra.inverted, 2u);
  EXPECT_EQ(s.inverted_cells, 2u);
  EXPECT_TRUE(std::isinf(s.tetrahedra.largest_aspect.value));
  EXPECT_NEAR(s.tetrahedra.largest_dihedral_deg.value, 180, 1e-9);
  EXPECT_EQ(s.tetrahedra.largest_dihedral_deg.tetrahedron, 6u);
  EXPECT_TRUE(s.tetrahedra.largest_dihedral_deg.centre_mm.isApprox(Vec3(1, 1, 10)));
  EXPECT_EQ(s.tetrahedra.above_165_deg, 1u);
  EXPECT_EQ(s.tetrahedra.below_5_deg, 1u);
  EXPECT_LT(s.tetrahedra.smallest_mean_ratio.value, 0);
}

TEST(Statistics, MixedCellsHaveTheirVolumeAndJacobian) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0},   {0, 0, 5},
                 {2, 0, 5}, {2, 3, 5}, {0, 3, 5}, {1, 1.5, 8},  // apex of a pyramid on top
                 {4, 0, 0}, {4, 0, 5}};                         // a prism at x > 2
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hexahedron_labels = {1};
  mesh.pyramids = {{4, 5, 6, 7, 8}};
  mesh.pyramid_labels = {2};
  mesh.prisms = {
      {1, 2, 9, 5, 6, 10}};  // seen from below the first triangle turns left: its normal points out
  mesh.prism_labels = {3};
  const MeshStatistics s = measure(mesh.view());
  ASSERT_EQ(s.labels.size(), 3u);
  EXPECT_NEAR(s.labels[0].volume_mm3, 30, 1e-12);
  EXPECT_NEAR(s.labels[1].volume_mm3, 6, 1e-12);
  EXPECT_NEAR(s.labels[2].volume_mm3, 15, 1e-12);
  EXPECT_EQ(s.inverted_cells, 0u);
  EXPECT_GT(s.smallest_scaled_jacobian, 0);
  EXPECT_LT(s.smallest_scaled_jacobian, 1);
  EXPECT_EQ(s.tetrahedra.count, 0u);
}

TEST(Statistics, SameBitsForEveryThreadCount) {
  MixedMesh mesh = to_mixed(fixtures::bcc_block(14));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    mesh.points[i] +=
        0.1 * Vec3(std::sin(3.0 * static_cast<double>(i)), std::cos(5.0 * static_cast<double>(i)), 0);
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const MeshStatistics s = measure(mesh.view());
    return std::array{s.tetrahedra.mean_mean_ratio, s.tetrahedra.mean_aspect, s.tetrahedra.mean_edge_mm,
                      s.labels[0].volume_mm3, s.tetrahedra.mean_smallest_dihedral_deg};
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

}  // namespace
}  // namespace lumesh::quality
