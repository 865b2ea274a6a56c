// Surfaces made anew (lumesh/stages/repair_stage.hpp).
#include "lumesh/stages/repair_stage.hpp"

#include <gtest/gtest.h>

#include "fixtures/surfaces.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {
namespace {

// Where results exist, loops no longer end when a stop comes.
TEST(RepairStage, AnIncompleteMeshOfARebuildIsNoResult) {
  const fixtures::TriangleSoup ball = fixtures::icosphere(3, 5);
  MixedMesh surface;
  surface.points = ball.points;
  surface.triangles = ball.triangles;
  surface.triangle_patches.assign(ball.triangles.size(), 0);
  surface.info.patches = {{"wall", PatchKind::kWall, {1, 0}}};
  RepairRequest request;
  request.method = RepairMethod::kRebuild;
  request.max_distance.number = 5;
  Context context;
  int results = 0;
  context.report_results_to([&] { ++results; });
  const RepairOutcome outcome = repair_surface(surface, request, context);
  EXPECT_TRUE(outcome.was_rebuilt);
  EXPECT_EQ(results, 0);
}

}  // namespace
}  // namespace lumesh
