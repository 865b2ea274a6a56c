#include "lumesh/stages/image_shape.hpp"

#include <gtest/gtest.h>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"

namespace lumesh {
namespace {

/// A cube of `edge` voxels of 1 mm from the middle of voxel (0, 0, 0) on.
LabelImage cube_image(int edge) {
  return fixtures::voxels_of(fixtures::frame_of({10, 10, 10}), {0, 1},
                             [&](const Vec3& p) { return p.maxCoeff() < edge - 0.5 ? 1 : 0; });
}

TEST(ImageShape, VolumesThatAreOffAreTold) {
  const TetMesh mesh = fixtures::cube_grid(5).build();
  EXPECT_TRUE(differences(shape_of(cube_image(5)), mesh).empty());
  const std::vector<std::string> lines = differences(shape_of(cube_image(6)), mesh);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("label 1 fills 42.1 % less than its voxels;"), std::string::npos) << lines[0];
  EXPECT_TRUE(differences(shape_of(cube_image(4)), mesh).empty()) << "64 voxels are too few to say";
}

}  // namespace
}  // namespace lumesh
