#include "lumesh/quality/hausdorff.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "../src/quality/voxel_faces.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {
namespace {

/// An image of size^3 voxels with a block of label 1 from low to high (inclusive).
LabelImage block_image(int size, const Index3& low, const Index3& high, const Vec3& spacing = Vec3::Ones()) {
  ImageFrame frame;
  frame.size = Index3::Constant(size);
  frame.spacing_mm = spacing;
  LabelImage image(frame, {0, 1});
  for (int k = low.z(); k <= high.z(); ++k)
    for (int j = low.y(); j <= high.y(); ++j)
      for (int i = low.x(); i <= high.x(); ++i) image.at({i, j, k}) = 1;
  return image;
}

ImageDistances compare(const MixedMesh& mesh, const LabelImage& image,
                       const std::vector<CutPlane>& planes = {}) {
  return compare_with_image(mesh.view(), extract_surface(mesh.view()), image, planes);
}

TEST(Hausdorff, MeshOnTheVoxelFacesHasDistanceZero) {
  // Voxels 2 to 5 cover [1.5, 5.5].
  const LabelImage image = block_image(8, Index3::Constant(2), Index3::Constant(5));
  const ImageDistances d = compare(fixtures::block_mesh(4, Vec3::Constant(1.5), Vec3::Constant(5.5)), image);
  ASSERT_TRUE(d.outer);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, 0, 1e-12);
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, 0, 1e-12);
  // Mesh corners are half a voxel's diagonal from the corner voxels' centres; so are all vertices at voxel
  // corners nearest in that sense: in the middle of a side the nearest boundary voxel centre is sqrt(3)/2
  // away, too.
  EXPECT_NEAR(d.outer->vertex_to_voxel_two_sided_mm, std::sqrt(3.0) / 2, 1e-12);
}

TEST(Hausdorff, MeshThatIsTooLargeIsAsFarAsItsSidesAndCorners) {
  const LabelImage image = block_image(12, Index3::Constant(4), Index3::Constant(7));  // [3.5, 7.5]
  const ImageDistances d = compare(fixtures::block_mesh(4, Vec3::Constant(2.5), Vec3::Constant(8.5)), image);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, std::sqrt(3.0), 1e-12);  // corner to corner
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, 1, 1e-12);               // side to side
  EXPECT_NEAR(d.outer->image_to_mesh_mm.mean, 1, 1e-12);
  EXPECT_NEAR(d.outer->image_to_mesh_mm.p95, 1, 1e-12);
  EXPECT_GT(d.outer->mesh_to_image_mm.mean, 1);
  EXPECT_LT(d.outer->mesh_to_image_mm.mean, 1.3);
}

TEST(Hausdorff, AnisotropicRotatedImagesAreMeasuredInMillimetres) {
  LabelImage image = block_image(10, {3, 3, 3}, {6, 6, 6}, {0.5, 1, 2});
  const double c = std::cos(0.4), s = std::sin(0.4);
  image.frame().direction << c, -s, 0, s, c, 0, 0, 0, -1;
  image.frame().origin_mm = {10, -20, 30};
  MixedMesh mesh = fixtures::block_mesh(4, {2.5, 2.5, 2.5}, {6.5, 6.5, 6.5});  // in voxels, so far
  for (Vec3& p : mesh.points) {
    p.z() += 0.25;  // half a millimetre along k
    p = image.frame().to_physical(p);
  }
  for (Cell<4>& t : mesh.tetrahedra) std::swap(t[0], t[1]);  // the frame is left-handed
  const ImageDistances d = compare(mesh, image);
  EXPECT_NEAR(d.voxel_size_mm, 1, 1e-12);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, 0.5, 1e-9);
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, 0.5, 1e-9);
  EXPECT_NEAR(d.labels.at(0).voxel_volume_mm3, 64, 1e-9);
}

TEST(Hausdorff, FacesOnTheImageBorderBelongToTheLabel) {
  const LabelImage image =
      block_image(4, Index3::Zero(), Index3::Constant(3));  // fills the image: [-0.5, 3.5]
  const ImageDistances d = compare(fixtures::block_mesh(4, Vec3::Constant(-0.5), Vec3::Constant(3.5)), image);
  ASSERT_TRUE(d.outer);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, 0, 1e-12);
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, 0, 1e-12);
}

TEST(Hausdorff, CutPlanesLeaveOutCapAndWhatLiesBeyond) {
  const LabelImage image = block_image(12, Index3::Constant(2), Index3::Constant(9));  // [1.5, 9.5]
  const MixedMesh half = fixtures::block_mesh(4, Vec3::Constant(1.5), {9.5, 9.5, 5.5});
  EXPECT_NEAR(compare(half, image).outer->image_to_mesh_mm.max, 4, 1e-12);
  const ImageDistances d = compare(half, image, {{Vec3(0, 0, 5.5), Vec3(0, 0, 3)}});
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, 0, 1e-12);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, 0, 1e-12);
}

TEST(Hausdorff, LabelsAreMeasuredOneByOneAndLostOnesHaveNoDistance) {
  LabelImage image(block_image(10, Index3::Constant(2), Index3::Constant(7)).frame(), {0, 4, 5, 9});
  for (int k = 2; k <= 7; ++k)
    for (int j = 2; j <= 7; ++j)
      for (int i = 2; i <= 7; ++i) image.at({i, j, k}) = i < 5 ? 1 : 2;
  image.at({0, 0, 0}) = 3;
  MixedMesh mesh = fixtures::block_mesh(6, Vec3::Constant(1.5), Vec3::Constant(7.5));
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    double x = 0;
    for (const std::uint32_t v : mesh.tetrahedra[t]) x += mesh.points[v].x() / 4;
    mesh.tetrahedron_labels[t] = x < 5.5 ? 4 : 5;  // the image has the interface at 4.5
  }
  const ImageDistances d = compare(mesh, image);
  ASSERT_EQ(d.labels.size(), 3u);
  EXPECT_EQ(d.labels[1].label, 5);
  EXPECT_NEAR(d.labels[0].distances->mesh_to_image_mm.max, 1, 1e-12);
  EXPECT_NEAR(d.labels[1].distances->image_to_mesh_mm.max, 1, 1e-12);
  EXPECT_EQ(d.labels[2].label, 9);
  EXPECT_EQ(d.labels[2].voxels, 1u);
  EXPECT_FALSE(d.labels[2].distances);
  EXPECT_NEAR(d.outer->mesh_to_image_mm.max, 0, 1e-12);                 // the interface is not outside
  EXPECT_NEAR(d.outer->image_to_mesh_mm.max, std::sqrt(3) * 2, 1e-12);  // the far corner of the lost voxel
}

TEST(Hausdorff, SphereIsWithinAVoxelOfItsVoxelsAndTheReverse) {
  const double radius = 9.3;
  ImageFrame frame;
  frame.size = Index3::Constant(24);
  LabelImage image(frame, {0, 1});
  const Vec3 centre = Vec3::Constant(11.4);
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) image.at({i, j, k}) = (Vec3(i, j, k) - centre).norm() < radius ? 1 : 0;
  MixedMesh mesh = fixtures::block_mesh(12, Vec3::Constant(-1), Vec3::Constant(1));
  for (Vec3& p : mesh.points) {  // cube to ball, ray by ray
    const double outer = p.cwiseAbs().maxCoeff();
    if (outer > 0) p *= radius * outer / p.norm();
    p += centre;
  }
  const ImageDistances d = compare(mesh, image);
  // A voxel face between a centre inside and one outside is less than half a voxel's diagonal off the sphere.
  EXPECT_LT(d.outer->mesh_to_image_mm.max, 0.9);
  EXPECT_LT(d.outer->image_to_mesh_mm.max, 0.9);
  EXPECT_GT(d.outer->image_to_mesh_mm.max, 0.4);
  EXPECT_LT(d.outer->mesh_to_image_mm.mean, 0.4);
  EXPECT_LT(d.outer->mesh_to_image_mm.p95, d.outer->mesh_to_image_mm.max);
}

TEST(FaceTree, AgreesWithTheSearchOverAllFaces) {
  std::mt19937 random(20240611);
  LabelImage image = block_image(9, {1, 2, 0}, {7, 6, 8}, {0.7, 1.3, 0.9});
  for (LabelImage::Index& v : image.voxels())
    if (random() % 4 == 0) v = 0;
  const std::vector<LabelFaces> labels = collect_voxel_faces(image);
  const FaceTree tree(labels.at(0).faces, image.frame().spacing_mm);
  std::uniform_real_distribution<double> place(-3, 14);
  for (int n = 0; n < 300; ++n) {
    const Vec3 p(place(random), place(random), place(random));
    double expected = 1e9;
    for (const VoxelFace& face : labels[0].faces) {
      double squared = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double centre = face.twice_centre[axis] / 2.0;
        const double reach = axis == face.axis ? 0 : 0.5;
        const double q = p[axis] / image.frame().spacing_mm[axis];
        const double gap = std::max(0.0, std::abs(q - centre) - reach) * image.frame().spacing_mm[axis];
        squared += gap * gap;
      }
      expected = std::min(expected, std::sqrt(squared));
    }
    EXPECT_NEAR(tree.distance(p), expected, 1e-12) << "seed 20240611, query " << n;
  }
}

TEST(VoxelFaces, CountsAreThoseOfABlockAndNamesTheOwners) {
  const LabelImage image = block_image(5, {0, 1, 1}, {2, 2, 3});  // 3 x 2 x 3 voxels at the border i = 0
  const std::vector<LabelFaces> labels = collect_voxel_faces(image);
  ASSERT_EQ(labels.size(), 1u);
  EXPECT_EQ(labels[0].voxels, 18u);
  EXPECT_EQ(labels[0].faces.size(), 2u * (3 * 2 + 2 * 3 + 3 * 3));
  for (const VoxelFace& face : labels[0].faces) EXPECT_EQ(image.at(face.voxel()), 1);
  EXPECT_EQ(boundary_voxels(labels[0].faces).size(), 18u);  // two voxels thick: all are at the boundary
}

TEST(Hausdorff, SameBitsForEveryThreadCount) {
  const LabelImage image = block_image(20, Index3::Constant(3), Index3::Constant(16));
  const MixedMesh mesh = fixtures::block_mesh(9, Vec3::Constant(2.8), Vec3::Constant(16.9));
  const auto fingerprint = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const ImageDistances d = compare(mesh, image);
    return std::array{d.outer->mesh_to_image_mm.mean, d.outer->mesh_to_image_mm.p95,
                      d.outer->image_to_mesh_mm.mean, d.outer->image_to_mesh_mm.max};
  };
  EXPECT_EQ(fingerprint(1), fingerprint(4));
}

}  // namespace
}  // namespace lumesh::quality
