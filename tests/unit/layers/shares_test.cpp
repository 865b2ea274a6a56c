// What a report says of every place, against the mesh and the options it is of.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh {
namespace {

LayerReport report_of_cube(const LayerOptions& options) {
  const fixtures::TetSoup soup = fixtures::cube_grid(4);
  const BoundaryFaces faces = soup.build().boundary_faces();
  const std::vector<std::int32_t> patches(faces.triangles.size(), 0);
  MeshInfo info;
  info.patches = {{"wall", PatchKind::kWall, {1, kBackground}}};
  Context context;
  return grow_layers(
             TetMesh::build(soup.points, soup.tets, soup.labels, PatchTable{faces.triangles, patches}, info),
             options, context)
      .report;
}

/// Volume within closed triangles: positive if they are anticlockwise seen from outside.
double volume_within(const LayerShares& surface) {
  double six_volumes = 0;
  for (const auto& [a, b, c] : surface.triangles)
    six_volumes += surface.points[a].cross(surface.points[b]).dot(surface.points[c]);
  return six_volumes / 6;
}

TEST(LayerShares, LieOnTheSurfaceWhicheverSideTheLayersAre) {
  for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward}) {
    LayerOptions options;
    options.side = side;
    options.first_height = 0.02;
    options.count = 2;
    const LayerReport report = report_of_cube(options);
    EXPECT_EQ(report.surface.triangles.size(), 6u * 2 * 4 * 4);
    ASSERT_EQ(report.surface.of_points.size(), report.surface.points.size());
    EXPECT_NEAR(volume_within(report.surface), 64, 1e-9);
    for (const double share : report.surface.of_points) {
      EXPECT_GE(share, 0);
      EXPECT_LE(share, 1);
    }
    const LayerCoverage& wall = report.patches.at(0);
    EXPECT_EQ(wall.layers, 2);
    EXPECT_NEAR(wall.layered + wall.unlayered, 1, 1e-12);
    EXPECT_NEAR(wall.area_mm2, 96, 1e-9);
  }
}

TEST(LayerHeights, AreThoseOfACompleteColumn) {
  LayerOptions options;
  options.first_height = 0.1;
  options.growth = 2;
  options.count = 3;
  const std::vector<double> heights = layer_heights(options);
  ASSERT_EQ(heights.size(), 3u);
  EXPECT_NEAR(heights[0], 0.1, 1e-12);
  EXPECT_NEAR(heights[2], 0.4, 1e-12);
  options.count = 0;
  EXPECT_EQ(layer_heights(options).size(), 1u) << "sizes choose the number";
  EXPECT_EQ(layer_heights(options, 0.9).size(), 4u) << "0.1, 0.2, 0.4, 0.8";
}

}  // namespace
}  // namespace lumesh
