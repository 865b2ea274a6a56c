// Metrics given to meshes of files (lumesh/stages/metric_stage.hpp).
#include "lumesh/stages/metric_stage.hpp"

#include <gtest/gtest.h>

#include <string>

#include "fixtures/meshes.hpp"
#include "fixtures/mixed_meshes.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// What give_metric() says against a request; "nothing" if it takes it.
std::string refusal_of(const MeshMetricRequest& request, ErrorKind kind) {
  MixedMesh input = fixtures::mixed_of(fixtures::cube_grid(2).build());
  Context context;
  try {
    static_cast<void>(give_metric(input, "cube.vtu", request, context));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind);
    return error.what();
  }
  return "nothing";
}

TEST(MetricStage, AMeshWithoutMetricIsToldEverySource) {
  const std::string refusal = refusal_of({}, ErrorKind::kBadInput);
  EXPECT_TRUE(refusal.starts_with("cube.vtu: carries no metric; ")) << refusal;
  for (const std::string& source : metric::MetricRequest::source_options())
    EXPECT_NE(refusal.find('`' + source + '`'), std::string::npos) << source;
}

TEST(MetricStage, ThePhantomsFlowIsKnownToCasesAlone) {
  MeshMetricRequest request;
  request.metric.source<metric::VelocitySource>().velocity = "phantom";
  EXPECT_NE(refusal_of(request, ErrorKind::kUsage).find("lumesh phantom --velocity"), std::string::npos);
}

TEST(MetricStage, LimitsHoldAndTheComplexityIsThatOfTheFormulaOnTheMesh) {
  MixedMesh input = fixtures::mixed_of(fixtures::cube_grid(4).build());  // 64 mm^3.
  input.metric.assign(input.points.size(), SymTensor::diagonal(1, 1, 1));
  MeshMetricRequest request;
  request.metric.limits.largest_mm = 0.5;
  Context context;
  MeshWithMetric made = give_metric(input, "cube.vtu", request, context);
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
  Context context;
  EXPECT_NE(give_metric(input, "cube.vtu", request, context).result.unmet, "");
}

}  // namespace
}  // namespace lumesh
