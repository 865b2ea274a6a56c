// Surfaces made anew (lumesh/stages/repair_stage.hpp).
#include "lumesh/stages/repair_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {
namespace {

MixedMesh ball() {
  const fixtures::TriangleSoup soup = fixtures::icosphere(3, 5);
  MixedMesh surface;
  surface.points = soup.points;
  surface.triangles = soup.triangles;
  surface.triangle_patches.assign(soup.triangles.size(), 0);
  surface.info.patches = {{"wall", PatchKind::kWall, {1, 0}}};
  return surface;
}

/// A ball and a disc of so many triangles beside it, whose rim has a vertex of the ball.
MixedMesh ball_with_disc(std::uint32_t triangles) {
  MixedMesh surface = ball();
  const Vec3 at = surface.points[0], outwards = at.normalized(), across = outwards.unitOrthogonal();
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  surface.points.push_back(at + 0.5 * outwards);
  for (std::uint32_t i = 1; i < triangles; ++i) {
    const double angle = 2 * std::numbers::pi * i / triangles;
    surface.points.push_back(at + 0.5 * outwards -
                             0.5 * (std::cos(angle) * outwards + std::sin(angle) * across));
  }
  for (std::uint32_t i = 0; i < triangles; ++i)
    surface.triangles.push_back({first, i == 0 ? 0 : first + i, i + 1 == triangles ? 0 : first + i + 1});
  surface.triangle_patches.resize(surface.triangles.size(), 0);
  return surface;
}

// Where results exist, loops no longer end when a stop comes.
TEST(RepairStage, AnIncompleteMeshOfARebuildIsNoResult) {
  RepairRequest request;
  request.method = RepairMethod::kRebuild;
  request.max_distance.number = 5;
  Context context;
  int results = 0;
  context.report_results_to([&] { ++results; });
  const RepairOutcome outcome = repair_surface(ball(), request, context);
  EXPECT_TRUE(outcome.was_rebuilt);
  EXPECT_EQ(results, 0);
}

TEST(RepairStage, ALargePartThatHangsAtAPointIsLeftOutWithAWarning) {
  for (const std::uint32_t triangles : {8U, 24U}) {
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    const MixedMesh given = ball_with_disc(triangles);
    const RepairOutcome outcome = repair_surface(given, {}, context);
    EXPECT_EQ(outcome.surface.triangles.size(), given.triangles.size() - triangles);
    ASSERT_EQ(warnings.size(), triangles == 24 ? 1U : 0U);
    for (const std::string& text : warnings) EXPECT_NE(text.find("24 triangles"), std::string::npos) << text;
  }
}

/// A ball of radius 5 and a triangle of 0.2 % of its area one beside it.
MixedMesh ball_with_stray_triangle() {
  MixedMesh surface = ball();
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  const double side = std::sqrt(0.002 * 4 * std::numbers::pi * 25 * 4 / std::numbers::sqrt3);
  for (const Vec3& corner :
       {Vec3(0, 0, 0), Vec3(side, 0, 0), Vec3(side / 2, side * std::numbers::sqrt3 / 2, 0)})
    surface.points.emplace_back(Vec3(0, 0, 6) + corner);
  surface.triangles.push_back({first, first + 1, first + 2});
  surface.triangle_patches.push_back(0);
  return surface;
}

TEST(RepairStage, AStrayTriangleBesideABallIsLeftOutAndTold) {
  for (const RepairMethod method : {RepairMethod::kLocal, RepairMethod::kRebuild}) {
    RepairRequest request;
    request.method = method;
    Context context;
    const RepairOutcome outcome = repair_surface(ball_with_stray_triangle(), request, context);
    EXPECT_EQ(outcome.report.stray_pieces, 1U);
    EXPECT_NEAR(outcome.report.stray_area_mm2, 0.002 * 4 * std::numbers::pi * 25, 1e-9);
    EXPECT_LT((outcome.report.stray_mm - Vec3(0, 0, 6)).norm(), 2);
    EXPECT_EQ(outcome.report.components, 1U);
    EXPECT_EQ(outcome.surface.triangles.size() == ball().triangles.size(), method == RepairMethod::kLocal);
  }
}

/// A sphere within another one is a cavity, whichever way it is turned.
TEST(RepairStage, CavitiesStayWhateverTheMethod) {
  for (const bool is_turned : {false, true}) {
    MixedMesh surface = ball();
    const auto count = static_cast<std::uint32_t>(surface.points.size());
    const std::vector<Cell<3>> outer = surface.triangles;
    for (std::uint32_t v = 0; v < count; ++v) surface.points.push_back(0.4 * surface.points[v]);
    for (const auto& [a, b, c] : outer)
      surface.triangles.push_back({a + count, (is_turned ? b : c) + count, (is_turned ? c : b) + count});
    surface.triangle_patches.assign(surface.triangles.size(), 0);
    for (const RepairMethod method : {RepairMethod::kLocal, RepairMethod::kRebuild}) {
      RepairRequest request;
      request.method = method;
      request.max_distance.number = 4;  // Percent.
      Context context({}, [&](std::string_view text) { ADD_FAILURE() << text; });
      const RepairOutcome outcome = repair_surface(surface, request, context);
      EXPECT_EQ(outcome.report.components, 2U);
      EXPECT_EQ(outcome.was_rebuilt, method == RepairMethod::kRebuild);
      double volume = 0;
      for (const auto& [a, b, c] : outcome.surface.triangles)
        volume += tetrahedron_volume(Vec3::Zero(), outcome.surface.points[a], outcome.surface.points[b],
                                     outcome.surface.points[c]);
      EXPECT_NEAR(volume, 4 * std::numbers::pi / 3 * 125 * (1 - 0.064), 12);
    }
  }
}

/// Two balls that cross, and a speck.
TEST(RepairStage, WhatRebuildingJoinsIsToldAndSpecksAreLeftOut) {
  MixedMesh surface = ball();
  const auto count = static_cast<std::uint32_t>(surface.points.size());
  const std::vector<Cell<3>> one = surface.triangles;
  const auto add = [&](double scale, const Vec3& by) {
    const auto first = static_cast<std::uint32_t>(surface.points.size());
    for (std::uint32_t v = 0; v < count; ++v) surface.points.push_back(scale * surface.points[v] + by);
    for (const auto& [a, b, c] : one) surface.triangles.push_back({a + first, b + first, c + first});
  };
  add(1, Vec3(6, 0.1, 0.2));
  add(0.003, Vec3(0, 12, 0));
  surface.triangle_patches.assign(surface.triangles.size(), 0);
  for (const RepairMethod method : {RepairMethod::kAuto, RepairMethod::kRebuild}) {
    RepairRequest request;
    request.method = method;
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    const RepairOutcome outcome = repair_surface(surface, request, context);
    EXPECT_EQ(outcome.was_rebuilt, method == RepairMethod::kRebuild);
    EXPECT_EQ(outcome.report.components, 1U);
    EXPECT_EQ(outcome.report.dropped_parts, 1U);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find("2 components have become 1"), std::string::npos) << warnings[0];
  }
}

/// Minutes went by with a heap of triangles before.
TEST(RepairStage, AHeapOfTrianglesIsRefused) {
  const MixedMesh whole = ball();
  MixedMesh heap = whole;
  heap.points.clear();
  for (Cell<3>& t : heap.triangles)
    for (std::uint32_t& v : t) {
      const auto number = static_cast<std::uint32_t>(heap.points.size());
      heap.points.push_back(whole.points[v] * (1 + 1e-3 * ((number * 7919) % 13)));
      v = number;
    }
  Context context;
  EXPECT_THROW(std::ignore = repair_surface(heap, {}, context), Error);
}

/// Reading memory beyond its end came of them.
TEST(RepairStage, TrianglesOfOnePlaceAreNoSurface) {
  MixedMesh surface = ball();
  surface.triangles = {{0, 1, 1}, {2, 2, 2}};
  surface.triangle_patches = {0, 0};
  Context context;
  for (const RepairMethod method : {RepairMethod::kAuto, RepairMethod::kLocal, RepairMethod::kRebuild}) {
    RepairRequest request;
    request.method = method;
    EXPECT_THROW(std::ignore = repair_surface(surface, request, context), Error);
  }
}

}  // namespace
}  // namespace lumesh
