// The figures that need a mesh and its image together.
#include "lumesh/quality/evaluation.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "fixtures/images.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/mesh/polylines.hpp"

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

/// Voxels of 1 mm around [0, 3]^3 with label 1 where `has` says so, against a mesh of the whole cube.
Evaluation evaluated_cube(const std::function<bool(const Vec3&)>& has) {
  const fixtures::TetSoup soup = fixtures::cube_grid(3);
  MixedMesh mesh;
  mesh.points = soup.points;
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  ImageFrame frame = frame_of({5, 5, 5});
  frame.origin_mm.setConstant(-0.5);
  const LabelImage image = voxels_of(frame, {0, 1}, [&](const Vec3& p) {
    return (p.array() > 0).all() && (p.array() < 3).all() && has(p) ? 1 : 0;
  });
  EvaluationInput input;
  input.image = &image;
  Context context;
  return evaluate(mesh.view(), input, context);
}

TEST(Evaluation, ListsWhatTheTopologyOfALabelDiffersIn) {
  using Words = std::vector<std::string>;
  const Vec3 middle = Vec3::Constant(1.5);
  EXPECT_EQ(evaluated_cube([](const Vec3&) { return true; }).topology_differences, Words());
  EXPECT_EQ(evaluated_cube([&](const Vec3& p) { return p != middle; }).topology_differences,
            Words({"label 1: cavities 0 (image 1)"}));
  EXPECT_EQ(
      evaluated_cube([&](const Vec3& p) { return p.head<2>() != middle.head<2>(); }).topology_differences,
      Words({"label 1: handles 0 (image 1)"}));
  EXPECT_EQ(evaluated_cube([&](const Vec3& p) { return p.x() != 1.5; }).topology_differences,
            Words({"label 1: components 1 (image 2)"}));
}

TEST(Evaluation, CountsCavitiesAndHandlesOfAMesh) {
  const fixtures::TetSoup soup = fixtures::cube_grid(5);
  const auto without = [&](const std::function<bool(const Vec3&)>& is_hole) {
    MixedMesh mesh;
    mesh.points = soup.points;
    for (const Cell<4>& tet : soup.tets) {
      Vec3 centre = Vec3::Zero();
      for (const std::uint32_t v : tet) centre += soup.points[v] / 4;
      if (!is_hole(centre.array().floor())) mesh.tetrahedra.push_back(tet);
    }
    mesh.tetrahedron_labels.assign(mesh.tetrahedra.size(), 1);
    Context context;
    const LabelEvaluation label = evaluate(mesh.view(), {}, context).labels.at(0);
    return std::pair(label.cavities(), label.handles());
  };
  using Pair = std::pair<std::optional<std::int64_t>, std::optional<std::int64_t>>;
  EXPECT_EQ(without([](const Vec3&) { return false; }), Pair(0, 0));
  EXPECT_EQ(without([](const Vec3& p) { return p == Vec3(1, 1, 1) || p == Vec3(3, 3, 3); }), Pair(2, 0));
  EXPECT_EQ(without([](const Vec3& p) { return p.x() == 1 && p.y() == 1; }), Pair(0, 1));
  EXPECT_EQ(without([](const Vec3& p) { return p == Vec3(3, 3, 3) || (p.x() == 1 && p.y() == 1); }),
            Pair(1, 1));
  // Two hollows that touch at an edge: no manifold.
  EXPECT_EQ(without([](const Vec3& p) { return p == Vec3(1, 1, 1) || p == Vec3(2, 2, 1); }),
            Pair(std::nullopt, std::nullopt));
}

TEST(Evaluation, TellsOfVoxelsKeptAndOfTheVolumeOfAllLabels) {
  const Evaluation evaluation = evaluated_cube([](const Vec3& p) { return p != Vec3::Constant(0.5); });
  EXPECT_NEAR(evaluation.volume_mm3(), 27, 1e-12);
  EXPECT_NEAR(evaluation.image_volume_error_percent(), 100 * (27.0 / 26 - 1), 1e-9);
  ASSERT_TRUE(evaluation.labels.at(0).voxels_kept);
  EXPECT_EQ(evaluation.labels[0].voxels_kept->counted, 26U);
  EXPECT_EQ(evaluation.labels[0].voxels_kept->kept, 26U);
  EXPECT_EQ(evaluation.image->background_kept.counted, 1U);
  EXPECT_EQ(evaluation.image->voxels_kept.counted, 27U);
  EXPECT_EQ(evaluation.image->voxels_kept.kept, 26U);
  EXPECT_EQ(evaluation.image->voxels_kept.worst->voxel, Index3(1, 1, 1));
}

TEST(Evaluation, WarnsOfAThroatThatTheMeshTightens) {
  // Voxels of 4 x 4 along z, and a mesh of 3.9 x 3.9.
  const fixtures::TetSoup soup = fixtures::cube_grid(12);
  MixedMesh mesh;
  for (const Vec3& p : soup.points)
    mesh.points.emplace_back(3.9 * (p.x() / 12 - 0.5), 3.9 * (p.y() / 12 - 0.5), p.z());
  mesh.tetrahedra = soup.tets;
  mesh.tetrahedron_labels = soup.labels;
  ImageFrame frame = frame_of({8, 8, 12});
  frame.origin_mm = {-3.5, -3.5, 0.5};
  const LabelImage image = voxels_of(
      frame, {0, 1}, [](const Vec3& p) { return std::max(std::abs(p.x()), std::abs(p.y())) < 2 ? 1 : 0; });
  Polylines axes;
  axes.points = {{0, 0, 0}, {0, 0, 4}, {0, 0, 8}, {0, 0, 12}};
  axes.lines = {{0, 1, 2, 3}};
  axes.scalars["radius"] = {2, 2, 2, 2};
  EvaluationInput input;
  input.image = &image;
  std::string heard;
  Context context({}, [&](std::string_view message) { heard = message; });
  EXPECT_FALSE(evaluate(mesh.view(), input, context).sections);
  EXPECT_EQ(heard, "");
  input.axes = &axes;
  const Evaluation evaluation = evaluate(mesh.view(), input, context);
  ASSERT_TRUE(evaluation.sections);
  EXPECT_NEAR(evaluation.sections->at(0).change_percent(), 100 * (3.9 * 3.9 / 16 - 1), 1e-6);
  ASSERT_EQ(evaluation.warnings.size(), 1U);
  EXPECT_EQ(evaluation.warnings[0], heard);
  EXPECT_NE(
      heard.find(
          "1 of 1 branches is more than 3 % narrower in the mesh than in the voxels; branch 0 by 4.9 %"),
      std::string::npos)
      << heard;
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
