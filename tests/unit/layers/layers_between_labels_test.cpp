// Layers on patches between labels, and on layers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "layer_fixtures.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

using fixtures::area_of;
using fixtures::copy_of;
using fixtures::expect_conforming;
using fixtures::grown;
using fixtures::kPi;
using fixtures::kTubeRadius;
using fixtures::meshed;
using fixtures::tube;
using fixtures::volume_of;

/// One layer after the other: names of patches and labels stay apart, and each label as it was.
TEST(Layers, OnLayersKeepNamesAndLabelsApart) {
  const LayerResult first = grown(tube(), {.first_height = 0.4, .count = 2});
  const LayerResult second = grown(TetMesh::build(first.mesh.view()), {.first_height = 0.4, .count = 2});
  const ValidationReport report = validate(second.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  std::set<std::string> names;
  for (const Patch& patch : second.mesh.info.patches)
    EXPECT_TRUE(names.insert(patch.name).second) << patch.name;
  EXPECT_NE(second.mesh.info.label_names.at(2), second.mesh.info.label_names.at(3));
  const LayerResult within = grown(TetMesh::build(second.mesh.view()),
                                   {.side = LayerSide::kInward, .into = 3, .first_height = 0.1, .count = 1});
  ASSERT_TRUE(validate(within.mesh.view()).ok());
  for (const Label label : {1, 2})
    EXPECT_NEAR(volume_of(within.mesh, label), volume_of(second.mesh, label), 1e-9);
  EXPECT_NEAR(volume_of(within.mesh, 3) + volume_of(within.mesh, 4), volume_of(second.mesh, 3), 1e-6);
}

/// A lumen of label 1 in a wall of label 2, along z, open at both ends.
constexpr double kWallRadius = 15;
TetMesh tube_in_tube() {
  return meshed(fixtures::voxels_of(fixtures::frame_of({40, 40, 50}), {0, 1, 2}, [](const Vec3& p) {
    const double r = std::hypot(p.x() - 19.5, p.y() - 19.5);
    return r < kTubeRadius ? 1 : r < kWallRadius ? 2 : 0;
  }));
}

/// Name of a patch between two labels, 0: nothing.
std::string patch_between(const MeshInfo& info, Label a, Label b) {
  for (const Patch& patch : info.patches)
    if (patch.kind != PatchKind::kOpening &&
        std::minmax(patch.labels[0], patch.labels[1]) == std::minmax(a, b))
      return patch.name;
  return "none";
}

TEST(Layers, InwardsOfAWallAroundALumenSayThatTheyAreInTheWall) {
  std::vector<std::string> told;
  Context context({}, [&](std::string_view message) { told.emplace_back(message); });
  const TetMesh vessel = tube_in_tube();
  LayerOptions options{.side = LayerSide::kInward, .first_height = 0.1, .count = 1};
  static_cast<void>(grow_layers(vessel, options, context));
  EXPECT_EQ(std::ranges::count_if(
                told, [](const std::string& line) { return line.starts_with("layers grow into label 2"); }),
            1);
  told.clear();
  options.into = 1;
  options.patches = {patch_between(vessel.info(), 1, 2)};
  static_cast<void>(grow_layers(vessel, options, context));
  EXPECT_TRUE(told.empty()) << told.front();
}

/// A vessel whose two labels meet in its middle, along z.
TEST(Layers, InwardsOfSeveralLabelsOfOneLumenAreAsOfOne) {
  const auto voxels = [](Label second) {
    return fixtures::voxels_of(fixtures::frame_of({28, 28, 50}), {0, 1, 2}, [second](const Vec3& p) -> int {
      return std::hypot(p.x() - 13.6, p.y() - 13.2) >= kTubeRadius ? 0 : p.z() < 24.3 ? 1 : second;
    });
  };
  const LayerOptions options{.side = LayerSide::kInward, .first_height = 0.3, .count = 4};
  const TetMesh mesh = meshed(voxels(2)), alike = meshed(voxels(1));
  const MixedMesh before = copy_of(mesh);
  const LayerResult result = grown(mesh, options), one = grown(alike, options);
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  expect_conforming(result.mesh);
  EXPECT_GT(result.report.complete(),
            one.report.complete() - 0.1);  // Coarse cells at the interface are poor.
  EXPECT_NEAR(volume_of(result.mesh, 1) + volume_of(result.mesh, 2) + volume_of(result.mesh, 3),
              volume_of(before, 1) + volume_of(before, 2), 1e-6 * volume_of(before, 1));
  const double share = volume_of(result.mesh, 1) / (volume_of(result.mesh, 1) + volume_of(result.mesh, 2));
  EXPECT_NEAR(share, volume_of(before, 1) / (volume_of(before, 1) + volume_of(before, 2)), 0.01);
  for (const Label label : {1, 2})
    EXPECT_GT(area_of(result.mesh, patch_between(mesh.info(), 0, label)),
              0.97 * area_of(before, patch_between(mesh.info(), 0, label)));
  // Their interface stays about where it was.
  const std::string between = patch_between(mesh.info(), 1, 2);
  const auto farthest_off = [&](const MixedMesh& of) {
    double off = 0;
    for (std::size_t t = 0; t < of.triangles.size(); ++t)
      if (of.info.patches[static_cast<std::size_t>(of.triangle_patches[t])].name == between)
        for (const std::uint32_t v : of.triangles[t]) off = std::max(off, std::abs(of.points[v].z() - 23.8));
    return off;
  };
  EXPECT_LT(area_of(result.mesh, between), area_of(before, between));
  EXPECT_LT(farthest_off(result.mesh), farthest_off(before) + 0.3);
}

TEST(Layers, OnPatchesBetweenLabelsGrowIntoEither) {
  const TetMesh mesh = tube_in_tube();
  const MixedMesh before = copy_of(mesh);
  const std::string between = patch_between(mesh.info(), 1, 2), outside = patch_between(mesh.info(), 0, 2);
  struct Case {
    std::string patch;
    Label into;
  };
  for (const Case& one : {Case{between, 1}, Case{between, 2}, Case{outside, 2}}) {
    SCOPED_TRACE(one.patch + " into " + std::to_string(one.into));
    const LayerResult result = grown(mesh, {.patches = {one.patch},
                                            .side = LayerSide::kInward,
                                            .into = one.into,
                                            .first_height = 0.15,
                                            .count = 3});
    const ValidationReport report = validate(result.mesh.view());
    ASSERT_TRUE(report.ok()) << report.text();
    expect_conforming(result.mesh);
    EXPECT_GT(result.report.complete(), 0.75);  // Between labels, the coarse lattice's surface has kinks.
    const Label other = 3 - one.into;
    EXPECT_NEAR(volume_of(result.mesh, other) / volume_of(before, other), 1, 1e-12);
    EXPECT_NEAR((volume_of(result.mesh, one.into) + volume_of(result.mesh, 3)) / volume_of(before, one.into),
                1, 1e-4);
    const double thickness = 0.15 * (1 + 1.2 + 1.44);
    const double radius = one.patch == between ? kTubeRadius : kWallRadius;
    const double middle =
        one.patch == between && one.into == 2 ? radius + thickness / 2 : radius - thickness / 2;
    const double area = area_of(before, one.patch), length = 50;
    EXPECT_NEAR(area / (2 * kPi * radius * length), 1, 0.07) << "kinks between labels make it larger";
    EXPECT_NEAR(volume_of(result.mesh, 3) / (area * middle / radius * thickness), 1, 0.06);
    const double unlayered = area_of(result.mesh, one.patch + "_bare");
    EXPECT_NEAR(area_of(result.mesh, one.patch) + unlayered, area, 1e-9 * area);
    EXPECT_LT(unlayered, 0.06 * area);
  }
}

TEST(Layers, BetweenLabelsAskInto) {
  const TetMesh mesh = tube_in_tube();
  const std::string between = patch_between(mesh.info(), 1, 2), outside = patch_between(mesh.info(), 0, 2);
  const auto fault = [&](const LayerOptions& options) -> std::string {
    try {
      grown(mesh, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward})
    EXPECT_NE(fault({.patches = {between}, .side = side, .first_height = 0.3, .count = 3})
                  .find("between labels 1, 2 and has no free side"),
              std::string::npos);
  EXPECT_NE(
      fault({.patches = {outside}, .side = LayerSide::kInward, .into = 1, .first_height = 0.3, .count = 3})
          .find("is not at label 1; it is at 2"),
      std::string::npos);
}

}  // namespace
}  // namespace lumesh
