// Flat cells against prisms, pyramids and tetrahedra whose angles and heights are known.
#include "lumesh/quality/layered.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lumesh::quality {
namespace {

/// A regular triangle of edge 1 in the plane z.
std::vector<Vec3> triangle_at(double z) {
  return {{0, 0, z}, {0.5, std::sqrt(3.0) / 2, z}, {1, 0, z}};
}

MixedMesh prism_of_height(double height) {
  MixedMesh mesh;
  mesh.points = triangle_at(0);
  for (const Vec3& p : triangle_at(height)) mesh.points.push_back(p);
  mesh.prisms = {{0, 1, 2, 3, 4, 5}};
  mesh.prism_labels = {2};
  return mesh;
}

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

TEST(FlatCells, ARightPrismHasItsTrianglesAnglesAndItsHeight) {
  const FlatCellShapes s = measure_flat_cells(prism_of_height(0.05).view());
  EXPECT_EQ(s.cells, 1u);
  EXPECT_NEAR(s.smallest_dihedral_deg, 60, 1e-9);
  EXPECT_NEAR(s.largest_dihedral_deg, 90, 1e-9);
  EXPECT_NEAR(s.largest_aspect, 1 / 0.05, 1e-9);
  EXPECT_NEAR(s.mean_aspect, 1 / 0.05, 1e-9);
}

TEST(FlatCells, APyramidLeansOverItsSquare) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.1}};
  mesh.pyramids = {{0, 1, 2, 3, 4}};
  mesh.pyramid_labels = {2};
  const FlatCellShapes s = measure_flat_cells(mesh.view());
  EXPECT_NEAR(s.smallest_dihedral_deg, degrees(std::atan(0.1 / 0.5)), 1e-9);
  // Neighbouring sides have normals (0, -0.2, 1) and (0.2, 0, 1), but for their length.
  EXPECT_NEAR(s.largest_dihedral_deg, 180 - degrees(std::acos(1 / 1.04)), 1e-9);
  EXPECT_NEAR(s.largest_aspect, 1 / 0.1, 1e-9);
}

TEST(FlatCells, ARegularTetrahedronIsAsHighAsItIs) {
  MixedMesh mesh;
  mesh.points = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.tetrahedron_labels = {1};
  const FlatCellShapes s = measure_flat_cells(mesh.view());
  EXPECT_NEAR(s.smallest_dihedral_deg, 70.528779, 1e-5);
  EXPECT_NEAR(s.largest_dihedral_deg, 70.528779, 1e-5);
  EXPECT_NEAR(s.largest_aspect, std::sqrt(1.5), 1e-9) << "edge per height";
}

TEST(FlatCells, NoneAreZeroes) {
  const FlatCellShapes s = measure_flat_cells(MixedMesh().view());
  EXPECT_EQ(s.cells, 0u);
  EXPECT_EQ(s.smallest_dihedral_deg, 0);
  EXPECT_EQ(s.mean_aspect, 0);
}

TEST(LayeredParts, TakesTheLastCellsAsThoseOfTheLayers) {
  MixedMesh mesh = prism_of_height(1);
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}};
  mesh.tetrahedron_labels = {1, 1, 2};
  const LayeredParts parts = parts_of(mesh.view(), {.layers = 2});
  EXPECT_EQ(parts.core.tetrahedra.size(), 2u);
  EXPECT_EQ(parts.core.prisms.size(), 0u);
  EXPECT_EQ(parts.layers.tetrahedra.size(), 1u);
  EXPECT_EQ(parts.layers.tetrahedron_labels[0], 2);
  EXPECT_EQ(parts.layers.prisms.size(), 1u);
}

TEST(LayeredParts, LeavesCellsOfOtherShapesToTheCore) {
  MixedMesh mesh = prism_of_height(1);
  mesh.prisms.push_back({0, 1, 2, 3, 4, 5});
  mesh.prism_labels.push_back(9);
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}};
  mesh.tetrahedron_labels = {1, 1, 9};
  mesh.pyramids = {{0, 1, 4, 3, 2}};
  mesh.pyramid_labels = {1};
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 0, 1}};
  mesh.hexahedron_labels = {1};
  const LayeredParts parts = parts_of(mesh.view(), {.layers = 2, .core_pyramids = 1, .core_prisms = 1});
  EXPECT_EQ(parts.core.cell_count(), 5u);
  EXPECT_EQ(parts.core.hexahedra.size(), 1u);
  EXPECT_EQ(parts.core.pyramids.size(), 1u);
  EXPECT_EQ(parts.layers.tetrahedron_labels[0], 9);
  ASSERT_EQ(parts.layers.prism_labels.size(), 1u);
  EXPECT_EQ(parts.layers.prism_labels[0], 9);
}

}  // namespace
}  // namespace lumesh::quality
