#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixtures/metric_cubes.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/operators/operators.hpp"

namespace lumesh::operators {
namespace {

using metric::MetricField;

/// A polygon of unit radius in the plane z = 0, cut into triangles around its first corner, with two vertices
/// at distance `height` below and above: flat tetrahedra, which those around the axis would better.
TetMesh double_pyramid(int corners, double height) {
  std::vector<Vec3> points;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    points.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  const auto below = static_cast<std::uint32_t>(corners), above = below + 1;
  points.emplace_back(0.01, 0.02,
                      -height);  // Beside the axis, so that no four vertices lie in a plane with it.
  points.emplace_back(-0.02, 0.01, height);
  std::vector<Cell<4>> tets;
  for (std::uint32_t k = 1; k + 1 < below; ++k) {
    tets.push_back({0, k, k + 1, above});
    tets.push_back({k + 1, k, 0, below});
  }
  const std::vector<Label> labels(tets.size(), 1);
  TetMesh mesh = TetMesh::build(points, tets, labels);
  fixtures::assign_metric(mesh, MetricField::uniform(1));
  return mesh;
}

class FaceRemovals : public testing::TestWithParam<int> {};

double worst_quality(const TetMesh& mesh) {
  double worst = 1;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    worst = std::min<double>(worst, mesh.quality(TetId(t)));
  return worst;
}

TEST_P(FaceRemovals, TurnsFacesBetweenTwoVerticesIntoTheirEdge) {
  const int corners = GetParam();
  TetMesh mesh = double_pyramid(corners, 0.4);
  const double volume = validate(mesh).labels[0].volume;
  EXPECT_NEAR(volume, 0.8 / 3 * corners / 2 * std::sin(2 * std::numbers::pi / corners), 1e-12);
  const double worst = worst_quality(mesh);
  const MetricField field = MetricField::uniform(1);
  const PatchShapes shapes = all_frozen(mesh);
  Kernel<NoLock> kernel({mesh, field, shapes});
  ASSERT_EQ(kernel.apply(FaceRemoval{}, {TetId(0), 3}), Outcome::kApplied);
  mesh.compact();
  const ValidationReport report = validate(mesh);
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_NEAR(report.labels[0].volume, volume, 1e-12);
  EXPECT_GE(worst_quality(mesh), worst);
  // The first face does not hold the axis: the removed ones reach from it to the one that does.
  const auto below = static_cast<std::uint32_t>(corners);
  std::uint32_t around_axis = 0;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    around_axis +=
        mesh.index_of(TetId(t), VertexId(below)) >= 0 && mesh.index_of(TetId(t), VertexId(below + 1)) >= 0;
  const std::uint32_t removed = around_axis - 2;
  EXPECT_GE(removed, static_cast<std::uint32_t>(corners - 1) / 2);
  EXPECT_EQ(mesh.tet_count(), 2 * static_cast<std::uint32_t>(corners - 2) - removed + 2);
}

INSTANTIATE_TEST_SUITE_P(Corners, FaceRemovals, testing::Values(3, 4, 5, 6, 8),
                         testing::PrintToStringParamName());

TEST(FaceRemovals, LeavesWhatItWouldNotBetter) {
  const MetricField field = MetricField::uniform(1);
  for (const auto& [corners, height] : {std::pair(3, 3.0), std::pair(20, 0.4)}) {  // Needles; too many faces.
    TetMesh mesh = double_pyramid(corners, height);
    const PatchShapes shapes = all_frozen(mesh);
    Kernel<NoLock> kernel({mesh, field, shapes});
    EXPECT_EQ(kernel.apply(FaceRemoval{}, {TetId(0), 3}), Outcome::kRejected);
    EXPECT_EQ(mesh.tet_count(), 2u * static_cast<std::uint32_t>(corners) - 4);
    EXPECT_TRUE(validate(mesh).ok());
  }
}

TEST(FaceRemovals, KeepsInterfaces) {
  TetMesh whole = double_pyramid(5, 0.4);
  std::vector<Label> labels;
  for (std::uint32_t t = 0; t < whole.tet_count(); ++t)
    labels.push_back(t % 2 == 0 ? 1 : 2);  // Above, below.
  TetMesh mesh = TetMesh::build(whole.points(), whole.tets(), labels);
  const MetricField field = MetricField::uniform(1);
  fixtures::assign_metric(mesh, field);
  const PatchShapes shapes = all_frozen(mesh);
  Kernel<NoLock> kernel({mesh, field, shapes});
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    for (int face = 0; face < 4; ++face)
      EXPECT_EQ(kernel.apply(FaceRemoval{}, {TetId(t), face}), Outcome::kRejected);
}

}  // namespace
}  // namespace lumesh::operators
