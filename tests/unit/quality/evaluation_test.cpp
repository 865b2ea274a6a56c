// The figures that need a mesh and its image together.
#include "lumesh/quality/evaluation.hpp"

#include <gtest/gtest.h>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"

namespace lumesh::quality {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// The cube [0, 4]^3 in voxels of 0.5 mm: label 1 below x = 2, label 2 above.
LabelImage two_label_cube() {
  ImageFrame frame = frame_of({12, 12, 12});
  frame.spacing_mm.setConstant(0.5);
  frame.origin_mm.setConstant(-0.75);
  return voxels_of(frame, {0, 1, 2}, [](const Vec3& p) {
    const bool inside = (p.array() > 0).all() && (p.array() < 4).all();
    return !inside ? 0 : p.x() < 2 ? 1 : 2;
  });
}

Evaluation evaluated(const std::vector<CutPlane>& cut_planes) {
  const fixtures::TetSoup soup = fixtures::two_label_block(4);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  const LabelImage image = two_label_cube();
  EvaluationInput input;
  input.image = &image;
  input.cut_planes = cut_planes;
  Context context;
  return evaluate(mesh.view(), input, context);
}

std::vector<double> image_volumes(const Evaluation& evaluation) {
  std::vector<double> volumes;
  for (const LabelEvaluation& label : evaluation.labels) volumes.push_back(label.image->volume_mm3);
  volumes.push_back(evaluation.image->all.volume_mm3);
  return volumes;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& truth, double tolerance) {
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(found[i], truth[i], tolerance) << i;
}

TEST(Evaluation, WithoutCutsAllVoxelsCount) {
  expect_near(image_volumes(evaluated({})), {32, 32, 64}, 1e-9);
}

TEST(Evaluation, VoxelsThatACutPassesThroughCountByTheirShare) {
  // Not at a border of voxels, and the normal is not of unit length.
  expect_near(image_volumes(evaluated({{{2.8, 0, 0}, {3, 0, 0}}})), {32, 0.8 * 16, 44.8}, 1e-9);
  expect_near(image_volumes(evaluated({{{2.8, 0, 0}, {1, 0, 0}}, {{0, 0, 1.3}, {0, 0, -1}}})),
              {2 * 4 * 2.7, 0.8 * 4 * 2.7, 2.8 * 4 * 2.7}, 1e-9);
}

TEST(Evaluation, AnObliqueCutThroughTheMiddleHalvesBothLabels) {
  expect_near(image_volumes(evaluated({{{2, 2, 2}, {0, 1, -2}}})), {16, 16, 32}, 1e-9);
}

TEST(Evaluation, ALabelThatWasCutOffIsNotLost) {
  Evaluation evaluation = evaluated({{{1.5, 0, 0}, {1, 0, 0}}});
  LabelEvaluation& cut_off = evaluation.labels.at(1);
  EXPECT_EQ(cut_off.image->volume_mm3, 0);
  cut_off.cells = 0;
  EXPECT_FALSE(cut_off.lost());
  EXPECT_EQ(cut_off.image_volume_error_percent(), 0);
  LabelEvaluation& kept = evaluation.labels.at(0);
  kept.cells = 0;
  EXPECT_TRUE(kept.lost());
}

TEST(Evaluation, TheAdjacencyOfAKernelMeshGivesWhatItsFacesDo) {
  const TetMesh mesh = fixtures::two_label_block(4).build();
  const BoundaryFaces faces = mesh.boundary_faces();
  Context context;
  const Evaluation from_faces = evaluate(mesh.view(faces), {}, context);
  EvaluationInput input;
  input.kernel = &mesh;
  const Evaluation from_kernel = evaluate(mesh.view(faces), input, context);
  for (const Evaluation* e : {&from_faces, &from_kernel}) {
    EXPECT_TRUE(e->valid());
    EXPECT_EQ(e->components, 1U);
    EXPECT_EQ(e->euler, 1);
    EXPECT_EQ(e->boundary.triangles, 6U * 16 * 2);
    EXPECT_EQ(e->boundary.genus(), 0);
    EXPECT_EQ(e->interface_triangles, 16U * 2);
    ASSERT_EQ(e->labels.size(), 2U);
    for (const LabelEvaluation& label : e->labels) {
      EXPECT_EQ(label.components, 1U);
      EXPECT_EQ(label.euler, 1);
      EXPECT_TRUE(label.surface.manifold());
      EXPECT_EQ(label.surface.triangles, (2U * 16 + 4 * 8) * 2);
    }
    ASSERT_EQ(e->patches.size(), from_faces.patches.size());
    for (std::size_t p = 0; p < e->patches.size(); ++p) {
      EXPECT_EQ(e->patches[p].name, from_faces.patches[p].name);
      EXPECT_EQ(e->patches[p].faces, from_faces.patches[p].faces);
    }
  }
}

}  // namespace
}  // namespace lumesh::quality
