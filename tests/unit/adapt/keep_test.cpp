#include "lumesh/adapt/keep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "fixtures/meshes.hpp"
#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

using Place = std::array<double, 3>;

/// A block of two labels, its boundary listed.
MixedMesh block() {
  const TetMesh mesh = fixtures::two_label_block(4).build();
  const BoundaryFaces faces = mesh.boundary_faces();
  return copy_of(mesh.view(faces));
}

/// The tetrahedra of a label, by the places of their corners in their order.
std::vector<std::array<Place, 4>> cells_of(const MixedMesh& mesh, Label label) {
  std::vector<std::array<Place, 4>> cells;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    if (mesh.tetrahedron_labels[t] != label) continue;
    std::array<Place, 4>& cell = cells.emplace_back();
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3& p = mesh.points[mesh.tetrahedra[t][i]];
      cell[i] = {p.x(), p.y(), p.z()};
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

TEST(Keep, OneLabelStaysWhileTheOtherBecomesFinerOrCoarser) {
  const MixedMesh before = block();
  for (const double size : {0.5, 2.5}) {
    const KeptCells kept(before, {2});
    EXPECT_EQ(kept.kept_count(), before.tetrahedra.size() / 2);
    TetMesh mesh = TetMesh::build(kept.free_part().view());
    Context context;
    const AdaptedBoundary boundary(mesh, {.frozen_patches = kept.frozen_patches()}, context);
    adapt(mesh, metric::MetricField::uniform(size), boundary.shapes(), {}, context);
    boundary.restore_patches(mesh);
    const MixedMesh after = kept.put_back(mesh);
    EXPECT_EQ(cells_of(after, 2), cells_of(before, 2));
    const std::size_t count = cells_of(after, 1).size();
    EXPECT_TRUE(size < 1 ? count > 1000 : count < 190) << count;
    const ValidationReport report = validate(after.view());
    ASSERT_TRUE(report.ok()) << report.text();
    for (const LabelBoundary& label : report.labels) EXPECT_NEAR(label.volume, 32, 1e-9);
    ASSERT_EQ(after.info.patches.size(), before.info.patches.size());
    for (std::size_t p = 0; p < before.info.patches.size(); ++p) {
      EXPECT_EQ(after.info.patches[p].name, before.info.patches[p].name);
      EXPECT_EQ(after.info.patches[p].kind, before.info.patches[p].kind);
    }
    EXPECT_EQ(after.metric.size(), after.points.size());
  }
}

TEST(Keep, TheFacesAgainstKeptCellsAreFrozen) {
  const MixedMesh mesh = block();
  const KeptCells kept(mesh, {2});
  ASSERT_EQ(kept.frozen_patches().size(), 1U);
  const PatchId frozen = kept.frozen_patches()[0];
  EXPECT_EQ(kept.free_part().info.patches[frozen.value].name, "interface_1_2");
  for (std::size_t f = 0; f < kept.free_part().triangles.size(); ++f) {
    const Cell<3>& face = kept.free_part().triangles[f];
    const bool between = std::all_of(face.begin(), face.end(),
                                     [&](std::uint32_t v) { return kept.free_part().points[v].x() == 2; });
    EXPECT_EQ(between, kept.free_part().triangle_patches[f] == static_cast<std::int32_t>(frozen.value));
  }
}

TEST(Keep, NothingToChangeIsRefused) {
  EXPECT_THROW(KeptCells(block(), {1, 2}), Error);
  MixedMesh mesh = block();
  mesh.hexahedra = {{0, 1, 6, 5, 25, 26, 31, 30}};
  mesh.hexahedron_labels = {1};
  mesh.tetrahedra.erase(mesh.tetrahedra.begin(), mesh.tetrahedra.begin() + 6);  // Those of the first cube.
  mesh.tetrahedron_labels.erase(mesh.tetrahedron_labels.begin(), mesh.tetrahedron_labels.begin() + 6);
  EXPECT_THROW(KeptCells(mesh, {2}), Error);
}

TEST(Keep, TheOwnMetricOfARegularTetrahedronHasUnitEdges) {
  MixedMesh mesh;
  mesh.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.tetrahedra = {{0, 2, 1, 3}};
  mesh.tetrahedron_labels = {1};
  // Of the three edges at a corner, the mean of the squares of their lengths.
  const std::vector<SymTensor> metric = own_metric(mesh);
  ASSERT_EQ(metric.size(), 4U);
  double sum = 0;
  for (std::uint32_t v = 1; v < 4; ++v) sum += metric[0].quadratic(mesh.points[v] - mesh.points[0]) / 3;
  EXPECT_NEAR(sum, 1, 1e-12);
}

}  // namespace
}  // namespace lumesh
