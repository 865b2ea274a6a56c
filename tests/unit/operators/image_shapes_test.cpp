#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fixtures/curved_meshes.hpp"
#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/patch_shapes.hpp"

namespace lumesh::operators {
namespace {

const Vec3 kCentre(16.2, 15.9, 16.4);

/// A ball of radius 12 mm in voxels of 1 mm.
std::shared_ptr<const ImageDomain> image_of_ball(Label label) {
  const LabelImage image =
      fixtures::voxels_of(fixtures::frame_of({33, 33, 33}), {0, label},
                          [](const Vec3& p) { return (p - kCentre).norm() < 12 ? 1 : 0; });
  return std::make_shared<const ImageDomain>(image, ImageDomainOptions{});
}

/// A coarse ball: 42 vertices on its sphere.
TetMesh ball_of(double radius) {
  TetMesh mesh = fixtures::ball(1);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    mesh.set_point(VertexId(v), kCentre + radius * mesh.point(VertexId(v)));
  return mesh;
}

/// The same, larger by so much that it has the volume of the ball.
TetMesh ball_with_volume_of(double radius) {
  const double share = validate(fixtures::ball(1)).labels[0].volume / (4 * std::numbers::pi / 3);
  return ball_of(radius / std::cbrt(share));
}

TEST(FollowImage, MakesACoarseMeshAsRoundAsItsImageAndKeepsItsSize) {
  const TetMesh mesh = ball_with_volume_of(12.3);
  PatchShapes shapes = shapes_of_patches(mesh);
  follow_image(mesh, image_of_ball(1), shapes);
  ASSERT_EQ(shapes.size(), 1u);
  ASSERT_EQ(shapes[0].freedom, PatchFreedom::kCurved);
  int far_off = 0;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 500; ++n) {
    const Vec3 outwards = Vec3(normal(random), normal(random), normal(random)).normalized();
    const SurfacePoint found = shapes[0].surface->closest(kCentre + 12 * outwards);
    const double off = (found.point - kCentre).norm() - 12.3;
    EXPECT_NEAR(off, 0, 0.35);
    far_off += std::abs(off) > 0.12 ? 1 : 0;
    EXPECT_GT(found.normal.dot(outwards), 0.96);  // 16 degrees.
  }
  EXPECT_LT(far_off, 25);  // Where the ball touches a layer of voxels, it is flatter.
}

/// Its triangles lie inside the image's ball, but its vertices on the sphere: it is coarse, not smaller.
TEST(FollowImage, ACoarseMeshWithItsVerticesOnTheBoundaryGetsTheVolumeOfTheImage) {
  const TetMesh mesh = ball_of(12);
  PatchShapes shapes = shapes_of_patches(mesh);
  follow_image(mesh, image_of_ball(1), shapes);
  double mean = 0;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  constexpr int kCount = 500;
  for (int n = 0; n < kCount; ++n) {
    const Vec3 outwards = Vec3(normal(random), normal(random), normal(random)).normalized();
    mean += (shapes[0].surface->closest(kCentre + 12 * outwards).point - kCentre).norm() / kCount;
  }
  EXPECT_NEAR(mean, 12, 0.1);
}

TEST(FollowImage, RefusesAnImageOfSomethingElse) {
  const auto follow = [](const TetMesh& mesh, Label label) {
    PatchShapes shapes = shapes_of_patches(mesh);
    follow_image(mesh, image_of_ball(label), shapes);
  };
  EXPECT_NO_THROW(follow(ball_of(11.5), 1));
  EXPECT_THROW(follow(ball_of(9), 1), Error);
  EXPECT_THROW(follow(ball_of(12), 2), Error);
}

}  // namespace
}  // namespace lumesh::operators
