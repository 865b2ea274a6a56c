#include "lumesh/mesh/merge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "fixtures/meshes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// A cube of six tetrahedra, its corners moved by `place`; where that mirrors it, it is turned round.
template <class Place>
MixedMesh cube_at(const Place& place, Label label = 1) {
  fixtures::TetSoup soup = fixtures::cube_of_6(label);
  for (Vec3& p : soup.points) p = place(p);
  for (Cell<4>& t : soup.tets) {
    const auto at = [&](std::size_t i) -> const Vec3& { return soup.points[t[i]]; };
    if (tetrahedron_volume(at(0), at(1), at(2), at(3)) < 0) std::swap(t[0], t[1]);
  }
  return fixtures::mixed_of(soup.build());
}
MixedMesh cube_shifted(double x, Label label = 1) {
  return cube_at([x](const Vec3& p) { return Vec3(p + Vec3(x, 0, 0)); }, label);
}

MixedMesh hexahedron_from(double x, Label label) {
  MixedMesh mesh;
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0), Vec3(0, 0, 1),
                        Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)})
    mesh.points.push_back(p + Vec3(x, 0, 0));
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hexahedron_labels = {label};
  mesh.quadrilaterals = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  mesh.quadrilateral_patches.assign(6, 0);
  mesh.info.patches = {{"wall", PatchKind::kWall, {label, kBackground}}};
  return mesh;
}

MergeResult merged(const std::vector<const MixedMesh*>& meshes, const MergeOptions& options = {}) {
  std::vector<MergePart> parts;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    parts.push_back({meshes[i], std::string(1, static_cast<char>('A' + i))});
  return merge_meshes(parts, options);
}

std::string fault_of(const std::vector<const MixedMesh*>& meshes, const MergeOptions& options = {}) {
  try {
    static_cast<void>(merged(meshes, options));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "no error";
}

/// The tetrahedra by their corners' places and labels: what a mesh is but for numbers.
std::multiset<std::vector<double>> cells_by_place(const MixedMesh& mesh) {
  std::multiset<std::vector<double>> cells;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    std::vector<std::array<double, 3>> corners;
    for (const std::uint32_t v : mesh.tetrahedra[t])
      corners.push_back({mesh.points[v].x(), mesh.points[v].y(), mesh.points[v].z()});
    std::sort(corners.begin(), corners.end());
    std::vector<double> key = {static_cast<double>(mesh.tetrahedron_labels[t])};
    for (const auto& corner : corners) key.insert(key.end(), corner.begin(), corner.end());
    cells.insert(key);
  }
  return cells;
}

std::set<std::string> patch_names(const MixedMesh& mesh) {
  std::set<std::string> names;
  for (const Patch& patch : mesh.info.patches) names.insert(patch.name);
  return names;
}

constexpr int kBlock = 4;  // Cells along the side of the block of two labels.

TEST(Merge, HalvesOfABlockBecomeTheBlock) {
  const MixedMesh block = fixtures::mixed_of(fixtures::two_label_block(kBlock).build());
  const MixedMesh left = part_of(block, {1}).mesh, right = part_of(block, {2}).mesh;
  EXPECT_EQ(left.tetrahedra.size(), block.tetrahedra.size() / 2);
  EXPECT_EQ(left.points.size(), 3U * 5 * 5);
  for (const auto& parts : {std::vector{&left, &right}, std::vector{&right, &left}}) {
    const MergeResult result = merged(parts);
    EXPECT_EQ(result.report.shared_faces, 2U * 4 * 4);
    EXPECT_EQ(result.report.shared_points, 5U * 5);
    EXPECT_NEAR(result.report.shared_area, 16, 1e-12);
    EXPECT_EQ(result.report.farthest, 0);
    EXPECT_EQ(result.mesh.points.size(), 5U * 5 * 5);
    EXPECT_EQ(cells_by_place(result.mesh), cells_by_place(block));
    EXPECT_EQ(patch_names(result.mesh), patch_names(block));
    const ValidationReport report = validate(result.mesh.view());
    ASSERT_TRUE(report.ok()) << report.text();
    ASSERT_EQ(report.labels.size(), 2U);
    for (const LabelBoundary& label : report.labels) {
      EXPECT_NEAR(label.volume, 32, 1e-12);
      EXPECT_EQ(label.surface_euler, 2);
    }
  }
}

TEST(Merge, PartsOfAMeshNameTheirCutFacesAsTheInterface) {
  const MixedMesh block = fixtures::mixed_of(fixtures::two_label_block(kBlock).build());
  const LabelPart part = part_of(block, {1});
  const MixedMesh& left = part.mesh;
  ASSERT_TRUE(validate(left.view()).ok());
  const auto cut = std::find_if(left.info.patches.begin(), left.info.patches.end(),
                                [](const Patch& patch) { return patch.name == "interface_1_2"; });
  ASSERT_NE(cut, left.info.patches.end());
  ASSERT_EQ(part.cut.size(), 1U);
  EXPECT_EQ(part.cut[0].value, cut - left.info.patches.begin());
  for (std::size_t v = 0; v < part.points.size(); ++v)
    EXPECT_EQ(left.points[v], block.points[part.points[v]]);
  EXPECT_EQ(cut->kind, PatchKind::kWall);
  EXPECT_EQ(cut->labels, (std::array<Label, 2>{1, kBackground}));
}

TEST(Merge, RoundedPointsTakeThePlaceOfTheFirst) {
  MixedMesh block = fixtures::mixed_of(fixtures::two_label_block(kBlock).build());
  for (Vec3& p : block.points) p = p / 3 + Vec3(100.1, 50.2, 0.3);
  const MixedMesh left = part_of(block, {1}).mesh;
  MixedMesh right = part_of(block, {2}).mesh;
  for (Vec3& p : right.points) p = p.cast<float>().cast<double>();
  const MergeResult result = merged({&left, &right});
  EXPECT_EQ(result.report.shared_points, 5U * 5);
  EXPECT_GT(result.report.farthest, 1e-7);
  EXPECT_TRUE(validate(result.mesh.view()).ok());
  EXPECT_TRUE(std::equal(left.points.begin(), left.points.end(), result.mesh.points.begin()));
  EXPECT_NE(fault_of({&left, &right}, {.tolerance = 0.0}).find("farther apart than 0"), std::string::npos);
  EXPECT_NE(fault_of({&left, &right}, {.tolerance = 0.3}).find("shortest edge"), std::string::npos);
}

TEST(Merge, PartsInAnyOrderAreJoinedThroughOthers) {
  const MixedMesh a = cube_shifted(0, 1), b = cube_shifted(1, 2), c = cube_shifted(2, 3);
  for (const auto& parts : {std::vector{&a, &b, &c}, std::vector{&a, &c, &b}, std::vector{&c, &a, &b}}) {
    const MergeResult result = merged(parts);
    EXPECT_EQ(result.report.shared_faces, 4U);
    EXPECT_EQ(result.mesh.points.size(), 16U);
    EXPECT_TRUE(validate(result.mesh.view()).ok());
    EXPECT_EQ(patch_names(result.mesh), (std::set<std::string>{"wall", "interface_1_2", "interface_2_3"}));
  }
}

TEST(Merge, HexahedraShareAQuadrilateral) {
  const MixedMesh a = hexahedron_from(0, 1), b = hexahedron_from(1, 2);
  const MergeResult result = merged({&a, &b});
  EXPECT_EQ(result.mesh.points.size(), 12U);
  EXPECT_EQ(result.mesh.quadrilaterals.size(), 11U);
  EXPECT_EQ(result.report.shared_faces, 1U);
  EXPECT_NEAR(result.report.shared_area, 1, 1e-12);
  const Patch& patch = result.mesh.info.patches.back();
  EXPECT_EQ(patch.name, "interface_1_2");
  EXPECT_EQ(patch.kind, PatchKind::kInterface);
  EXPECT_EQ(patch.labels, (std::array<Label, 2>{1, 2}));
}

TEST(Merge, WithinOneLabelNoFaceIsLeft) {
  const MixedMesh a = hexahedron_from(0, 1), b = hexahedron_from(1, 1);
  EXPECT_EQ(merged({&a, &b}).mesh.quadrilaterals.size(), 10U);
  const MergeResult apart = merged({&a, &b}, {.equal_labels = EqualLabels::kApart});
  EXPECT_EQ(apart.mesh.quadrilaterals.size(), 11U);
  EXPECT_EQ(apart.mesh.hexahedron_labels, (std::vector<Label>{1, 2}));
}

TEST(Merge, NamesSayWhatALabelIs) {
  MixedMesh a = hexahedron_from(0, 1), b = hexahedron_from(1, 1), c = hexahedron_from(2, 2);
  a.info.label_names = {{1, "lumen"}};
  b.info.label_names = {{1, "wall"}};
  c.info.label_names = {{2, "lumen"}};
  const MergeResult result = merged({&a, &b, &c});
  EXPECT_EQ(result.mesh.hexahedron_labels, (std::vector<Label>{1, 3, 1}));
  EXPECT_EQ(result.mesh.info.label_names, (std::map<Label, std::string>{{1, "lumen"}, {3, "wall"}}));
  ASSERT_EQ(result.report.renumbered.size(), 2U);
  EXPECT_EQ(result.report.renumbered[0].to, 3);
}

TEST(Merge, APatchOfAnotherKindGetsANameOfItsOwn) {
  MixedMesh a = hexahedron_from(0, 1);
  const MixedMesh b = hexahedron_from(1, 2);
  a.quadrilateral_patches[3] = 1;
  a.info.patches = {{"skin", PatchKind::kWall, {1, 0}}, {"wall", PatchKind::kWall, {1, 0}}};
  EXPECT_EQ(patch_names(merged({&a, &b}).mesh), (std::set<std::string>{"skin", "wall", "wall_2"}));
}

TEST(Merge, TheMetricStaysWhereAllPartsHaveOne) {
  MixedMesh a = hexahedron_from(0, 1), b = hexahedron_from(1, 2);
  a.metric.assign(8, {1, 0, 0, 1, 0, 1});
  EXPECT_TRUE(merged({&a, &b}).mesh.metric.empty());
  b.metric.assign(8, {4, 0, 0, 4, 0, 4});
  const MixedMesh mesh = merged({&a, &b}).mesh;
  ASSERT_EQ(mesh.metric.size(), 12U);
  EXPECT_EQ(std::count_if(mesh.metric.begin(), mesh.metric.end(), [](const auto& m) { return m.xx == 1; }),
            8);
}

TEST(Merge, WhatDoesNotFitIsRefused) {
  const MixedMesh cube = cube_shifted(0), far = cube_shifted(3), again = cube_shifted(0, 2);
  EXPECT_NE(fault_of({&cube, &far}).find("come within 2 of"), std::string::npos);
  EXPECT_NE(fault_of({&cube, &far}).find("unit and frame are one"), std::string::npos);
  EXPECT_NE(fault_of({&cube, &again}).find("overlap"), std::string::npos);
  EXPECT_NE(fault_of({&cube}).find("at least two"), std::string::npos);
  const MixedMesh other_diagonal = cube_at([](const Vec3& p) { return Vec3(p.x() + 1, 1 - p.y(), p.z()); });
  EXPECT_NE(fault_of({&cube, &other_diagonal}).find("differ"), std::string::npos);
  const MixedMesh hexahedron = hexahedron_from(1, 2);
  EXPECT_NE(fault_of({&cube, &hexahedron}).find("differ"), std::string::npos);
  MixedMesh finer = fixtures::mixed_of([] {
    fixtures::TetSoup soup = fixtures::cube_grid(2);
    for (Vec3& p : soup.points) p = p / 2 + Vec3(1, 0, 0);
    return soup.build();
  }());
  EXPECT_NE(fault_of({&cube, &finer}).find("differ"), std::string::npos);
  finer.info.unit = "cm";
  EXPECT_NE(fault_of({&cube, &finer}).find("unit"), std::string::npos);
}

TEST(Merge, TheSameForEveryNumberOfThreads) {
  const MixedMesh block = fixtures::mixed_of(fixtures::two_label_block(8).build());
  const MixedMesh left = part_of(block, {1}).mesh, right = part_of(block, {2}).mesh;
  const MixedMesh wanted = merged({&left, &right}).mesh;
  for (const int threads : {1, 3}) {
    const parallel::ThreadLimit limit(threads);
    const MixedMesh mesh = merged({&left, &right}).mesh;
    EXPECT_EQ(mesh.points, wanted.points);
    EXPECT_EQ(mesh.tetrahedra, wanted.tetrahedra);
    EXPECT_EQ(mesh.triangles, wanted.triangles);
    EXPECT_EQ(mesh.triangle_patches, wanted.triangle_patches);
  }
}

TEST(Parts, LabelsAreCalledByNamesOrNumbers) {
  MixedMesh mesh = fixtures::mixed_of(fixtures::two_label_block(2).build());
  mesh.info.label_names = {{2, "wall"}, {5, "plaque"}};
  EXPECT_EQ(labels_called(std::vector<std::string>{"wall"}, mesh), (std::set<Label>{2}));
  EXPECT_EQ(labels_called(std::vector<std::string>{"1", "wall"}, mesh), (std::set<Label>{1, 2}));
  for (const std::string unknown : {"plaque", "3", ""}) {
    try {
      static_cast<void>(labels_called(std::vector<std::string>{unknown}, mesh));
      ADD_FAILURE() << unknown;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("labels present: 1, 2 (wall)"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace lumesh
