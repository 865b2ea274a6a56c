// Metrics given to meshes of files (lumesh/stages/metric_stage.hpp).
#include "lumesh/stages/metric_stage.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "fixtures/meshes.hpp"
#include "fixtures/metric_cubes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"

namespace lumesh {
namespace {

/// What give_metric() says against a request; "nothing" if it takes it.
std::string refusal_of(const MeshMetricRequest& request, ErrorKind kind) {
  Context context;
  try {
    static_cast<void>(give_metric(fixtures::mixed_of(fixtures::cube_grid(2).build()), request, context));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind);
    return error.what();
  }
  return "nothing";
}

TEST(MetricStage, AMeshWithoutMetricIsToldEverySource) {
  MeshMetricRequest request;
  request.mesh = "cube.vtu";
  const std::string refusal = refusal_of(request, ErrorKind::kBadInput);
  EXPECT_TRUE(refusal.starts_with("cube.vtu: carries no metric; ")) << refusal;
  for (const std::string& source : metric::MetricRequest::source_options())
    EXPECT_NE(refusal.find('`' + source + '`'), std::string::npos) << source;
}

TEST(MeshMetricRequest, WhatBelongsToAnImageNeedsItAndAnImageNeedsCurvature) {
  MeshMetricRequest request;
  EXPECT_NO_THROW(request.validate());
  request.selection.labels = {"1"};
  EXPECT_THROW(request.validate(), Error);
  request.image = "image.nrrd";
  EXPECT_THROW(request.validate(), Error);
  request.metric.source<metric::CurvatureSource>().curvature = true;
  EXPECT_NO_THROW(request.validate());
}

TEST(MeshMetricRequest, RowsOfAllPointsAreRefusedWhereCellsAreKept) {
  for (const bool is_tensors : {true, false}) {
    MeshMetricRequest request;
    (is_tensors ? request.metric.source<metric::TensorSource>().file
                : request.metric.source<metric::HessianSource>().field) = "given.sol";
    EXPECT_NO_THROW(request.validate());
    request.keep = {"2"};
    EXPECT_THROW(request.validate(), Error);
  }
}

TEST(MetricStage, TheMeshOfAFileComesFinishedAndIsWrittenWithItsMetricOrTheMetricAlone) {
  const std::string path = ::testing::TempDir() + "metric_stage_";
  MeshMetricRequest request;
  request.mesh = path + "cube.vtu";
  request.metric.source<metric::AnalyticSource>().formula = metric::AnalyticKind::kLinear;
  write_mesh(request.mesh, fixtures::mixed_of(fixtures::unit_cube(2)).view());
  Context context;
  const MeshWithMetric made = give_metric(request, {"metric", "--analytic linear"}, context);
  const MeshView mesh = made.mesh.view();
  EXPECT_EQ(made.mesh.changing().info().provenance.at("input"), request.mesh);
  for (const char* const name : {"out.vtu", "out.sol"}) write_with_metric(path + name, mesh, context);
  const MixedMesh with_mesh = read_mesh(path + "out.vtu");
  const std::vector<SymTensor> alone = read_metric(path + "out.sol", mesh.points.size());
  ASSERT_EQ(with_mesh.metric.size(), mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    EXPECT_EQ(with_mesh.metric[v], mesh.metric[v]);
    EXPECT_EQ(alone[v], mesh.metric[v]);
  }
}

TEST(MetricStage, FilesThatHoldNoMetricAreRefused) {
  for (const char* const name : {"m.vtu", "m.vtk", "m.sol", "m.solb"})
    EXPECT_NO_THROW(require_holds_metric(name));
  EXPECT_THROW(require_holds_metric("m.stl"), Error);
}

TEST(MetricStage, ThePhantomsFlowIsKnownToCasesAlone) {
  MeshMetricRequest request;
  request.metric.source<metric::VelocitySource>().velocity = "phantom";
  EXPECT_NE(refusal_of(request, ErrorKind::kUsage).find("by `velocity` FILE"), std::string::npos);
}

TEST(MetricStage, LimitsHoldAndTheComplexityIsThatOfTheFormulaOnTheMesh) {
  MixedMesh input = fixtures::mixed_of(fixtures::cube_grid(4).build());  // 64 mm^3.
  input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, 1));
  MeshMetricRequest request;
  request.metric.limits.largest_mm = 0.5;
  Context context;
  MeshWithMetric made = give_metric(input, request, context);
  EXPECT_NEAR(made.result.complexity, 64 * 8, 1e-9 * 64 * 8);  // Sizes of 0.5 mm: a density of 8 per mm^3.
  EXPECT_EQ(made.result.unmet, "");
  made.mesh.finish_metric({});
  for (const SymTensor& tensor : made.mesh.view().metric) EXPECT_NEAR(tensor.xx, 4, 1e-12);
}

TEST(MetricStage, AComplexityThatBoundsKeepFromIsTold) {
  MixedMesh input = fixtures::mixed_of(fixtures::cube_grid(4).build());
  input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, 1));
  MeshMetricRequest request;
  request.metric.limits.smallest_mm = 1;
  request.metric.limits.complexity = 1000;
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  const std::string unmet = give_metric(input, request, context).result.unmet;
  EXPECT_NE(unmet, "");
  EXPECT_EQ(warnings, std::vector{unmet});
}

}  // namespace
}  // namespace lumesh
