// The adaptation of meshes of files (lumesh/stages/mesh_adaptation.hpp).
#include "lumesh/stages/mesh_adaptation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/meshes.hpp"
#include "fixtures/metric_cubes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

TEST(MeshAdaptationRequest, WhatBelongsToAnImageNeedsIt) {
  MeshAdaptationRequest request;
  EXPECT_NO_THROW(request.validate());
  request.selection.labels = {"1"};
  EXPECT_THROW(request.validate(), Error);
  request.image = "image.nrrd";
  EXPECT_NO_THROW(request.validate());
  request.stage.boundary.is_frozen = true;
  EXPECT_THROW(request.validate(), Error);
}

TEST(MeshAdaptation, AFormulasComplexityIsMet) {
  MeshAdaptationRequest request;
  request.mesh = ::testing::TempDir() + "mesh_adaptation_cube.vtu";
  write_mesh(request.mesh, fixtures::mixed_of(fixtures::unit_cube(4)).view());
  request.analytic.formula = metric::AnalyticKind::kLinear;
  request.complexity = 1000;
  Context context;
  const AdaptedMesh made = adapt_mesh(request, {"adapt", ""}, context);
  EXPECT_NEAR(made.result.report.complexity / 1000, 1, 0.02);
  EXPECT_EQ(made.mesh.changing().info().provenance.at("command"), "adapt");
  EXPECT_EQ(made.mesh.view().metric.size(), made.mesh.view().points.size());
  EXPECT_EQ(made.result.patches_on_image, 0u);
}

TEST(MeshAdaptation, ASurfaceThatNeedsManyMoreVerticesThanTheSizesIsNoted) {
  MixedMesh input = fixtures::mixed_of(fixtures::unit_cube(4));
  const SymTensor coarse = SymTensor::diagonal(0.01, 0.01, 0.01);  // Sizes of 10, in a cube of 1.
  input.metric.assign(input.points.size(), coarse);
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  const AdaptedMesh made = adapt_mesh(input, {}, context);
  EXPECT_EQ(warnings, made.result.notes);
  EXPECT_EQ(
      std::ranges::count_if(
          warnings, [](const std::string& text) { return text.find("the surface needs more") != text.npos; }),
      1);
}

TEST(MeshAdaptation, SeveralPiecesAreRefusedByName) {
  MixedMesh input = fixtures::mixed_of(fixtures::unit_cube(2));
  MixedMesh other = input;
  const auto offset = static_cast<std::uint32_t>(input.points.size());
  for (const Vec3& p : other.points) input.points.push_back(p + Vec3(3, 0, 0));
  for (Cell<4> cell : other.tetrahedra) {
    for (std::uint32_t& v : cell) v += offset;
    input.tetrahedra.push_back(cell);
  }
  input.tetrahedron_labels.resize(input.tetrahedra.size(), 1);
  input.triangles.clear();
  input.triangle_patches.clear();
  input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, 1));
  MeshAdaptationRequest request;
  request.mesh = "two.vtu";
  Context context;
  try {
    static_cast<void>(adapt_mesh(input, request, context));
    FAIL() << "two pieces were taken";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("two.vtu: has 2 pieces"), 0u) << error.what();
  }
}

TEST(AdaptTarget, SizesThatBoundsKeepFromTheComplexityAreNotScaled) {
  TetMesh mesh = fixtures::cube_grid(4).build();  // 64 mm^3.
  const std::vector<SymTensor> wanted(mesh.vertex_count(), SymTensor::diagonal(1, 1, 1));
  Context context;
  metric::MetricLimits limits;
  limits.complexity = 1000;
  metric::shape_metric(mesh, wanted, limits);
  EXPECT_EQ(target_of_metric(mesh, limits, context).complexity, 1000);
  limits.smallest_mm = 1;
  metric::shape_metric(mesh, wanted, limits);
  const AdaptTarget target = target_of_metric(mesh, limits, context);
  EXPECT_EQ(target.complexity, 0);
  EXPECT_NEAR(target.seen, 64, 1e-9 * 64);
}

}  // namespace
}  // namespace lumesh
