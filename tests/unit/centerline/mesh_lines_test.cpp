#include <gtest/gtest.h>

#include <numbers>

#include "fixtures/surfaces.hpp"
#include "line_measures.hpp"
#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

constexpr double kTube = 3.0, kLength = 30.0;
constexpr std::uint32_t kAround = 48, kAlong = 40;
constexpr std::int32_t kWallPatch = 0, kInletPatch = 1, kOutletPatch = 2;

/// A straight tube along z from 0 to kLength, around (1, 2), open at both ends.
MixedMesh open_tube() {
  MixedMesh mesh;
  for (std::uint32_t j = 0; j <= kAlong; ++j)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double turn = 2 * std::numbers::pi * i / kAround;
      mesh.points.emplace_back(1 + kTube * std::cos(turn), 2 + kTube * std::sin(turn), kLength * j / kAlong);
    }
  for (std::uint32_t j = 0; j < kAlong; ++j)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = j * kAround + i, b = j * kAround + (i + 1) % kAround;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
  mesh.triangle_patches.assign(mesh.triangles.size(), kWallPatch);
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}}};
  return mesh;
}

void add_cap(MixedMesh& mesh, std::uint32_t ring, double z, std::int32_t patch) {
  const auto centre = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(1, 2, z);
  for (std::uint32_t i = 0; i < kAround; ++i) {
    Cell<3> triangle = {ring * kAround + i, centre, ring * kAround + (i + 1) % kAround};
    if (ring > 0) std::swap(triangle[0], triangle[2]);
    mesh.triangles.push_back(triangle);
    mesh.triangle_patches.push_back(patch);
  }
}

MixedMesh closed_tube() {
  MixedMesh mesh = open_tube();
  add_cap(mesh, 0, 0, kInletPatch);
  add_cap(mesh, kAlong, kLength, kOutletPatch);
  mesh.info.patches.push_back({"inlet", PatchKind::kOpening, {1, 0}});
  mesh.info.patches.push_back({"outlet_1", PatchKind::kOpening, {1, 0}});
  return mesh;
}

std::pair<double, double> height_range(const Polylines& lines) {
  double low = lines.points.front().z(), high = low;
  for (const Vec3& p : lines.points) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  return {low, high};
}

void expect_axis(const Polylines& lines) {
  ASSERT_EQ(lines.lines.size(), 1U);
  for (const Vec3& p : lines.points) EXPECT_LT((p - Vec3(1, 2, p.z())).norm(), 0.05);
  for (const double radius : lines.scalars.at("radius")) EXPECT_NEAR(radius, kTube, 0.02 * kTube);
}

TEST(MeshLines, RunFromCapToCapOfATube) {
  Context context;
  const Polylines lines = extract_centerline(closed_tube().view(), {}, context);
  expect_axis(lines);
  const auto [low, high] = height_range(lines);
  EXPECT_NEAR(low, 0, 1e-6);
  EXPECT_NEAR(high, kLength, 1e-6);
}

TEST(MeshLines, TakeHolesAsOpeningsAndSaySo) {
  std::string warning;
  Context context({}, [&](std::string_view text) { warning = text; });
  const Polylines lines = extract_centerline(open_tube().view(), {}, context);
  expect_axis(lines);
  const auto [low, high] = height_range(lines);
  EXPECT_NEAR(low, 0, 1e-6);
  EXPECT_NEAR(high, kLength, 1e-6);
  EXPECT_NE(warning.find("2 holes"), std::string::npos) << warning;
}

/// The closed tube, its last part so much thinner.
MixedMesh narrowing_tube(double thin) {
  MixedMesh mesh = closed_tube();
  for (Vec3& p : mesh.points) {
    const double share = std::clamp((p.z() - 0.6 * kLength) / (0.1 * kLength), 0.0, 1.0);
    const double narrower = 1 - share * (1 - thin / kTube);
    p = {1 + narrower * (p.x() - 1), 2 + narrower * (p.y() - 2), p.z()};
  }
  return mesh;
}

TEST(MeshLines, ReachOpeningsTenTimesThinnerThanTheTrunk) {
  constexpr double kThin = 0.2;
  std::string warning;
  Context context({}, [&](std::string_view text) { warning = text; });
  const Polylines lines = extract_centerline(narrowing_tube(kThin).view(), {}, context);
  EXPECT_EQ(warning, "");
  ASSERT_EQ(lines.lines.size(), 1U);
  EXPECT_NEAR(height_range(lines).second, kLength, 1e-6);
  EXPECT_NEAR(lines.scalars.at("radius").back(), kThin, 0.1 * kThin);
}

TEST(MeshLines, SayWhichOpeningIsTooThinForTheVoxels) {
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  static_cast<void>(extract_centerline(narrowing_tube(0.2).view(), {.voxel_mm = 0.6}, context));
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings.back().find("no line to 1 opening (radius 0.2 mm at (1.0, 2.0, 30.0) mm)"),
            std::string::npos)
      << warnings.back();
}

/// The closed tube along a circle around z, so that its caps face each other.
MixedMesh bent_tube(double circle, double gap) {
  MixedMesh mesh = closed_tube();
  for (Vec3& p : mesh.points) {
    const double turn = (gap / 2 + p.z() / kLength * (2 * std::numbers::pi * circle - gap)) / circle;
    const double away = circle + p.x() - 1;
    p = {away * std::cos(turn), away * std::sin(turn), p.y() - 2};
  }
  return mesh;
}

TEST(MeshLines, DoNotCrossTheGapBetweenCapsThatFaceEachOther) {
  constexpr double kCircle = 9;
  for (const double gap : {0.1, 0.4, 1.0, 3.0, 6.0}) {
    Context context;
    const Polylines lines = extract_centerline(bent_tube(kCircle, gap).view(), {}, context);
    ASSERT_EQ(lines.lines.size(), 1U) << "gap " << gap;
    EXPECT_NEAR(length_mm(lines), 2 * std::numbers::pi * kCircle - gap, 0.5) << "gap " << gap;
    for (const std::uint32_t end : {lines.lines[0].front(), lines.lines[0].back()}) {
      EXPECT_NEAR(std::abs(lines.points[end].y()), gap / 2, 0.05) << "gap " << gap;
      EXPECT_LT((lines.points[end] - Vec3(kCircle, 0, 0)).norm(), 0.15 * kTube + gap / 2) << "gap " << gap;
    }
  }
}

TEST(MeshLines, EndOneRadiusBeforeCapsThatAreWall) {
  MixedMesh mesh = closed_tube();
  mesh.triangle_patches.assign(mesh.triangles.size(), kWallPatch);
  Context context;
  const Polylines lines = extract_centerline(mesh.view(), {}, context);
  ASSERT_EQ(lines.lines.size(), 1U);
  const auto [low, high] = height_range(lines);
  EXPECT_NEAR(low, kTube, 0.35 * kTube);
  EXPECT_NEAR(high, kLength - kTube, 0.35 * kTube);
}

TEST(MeshLines, AskPatchesForTheirKindNotTheirName) {
  MixedMesh mesh = closed_tube();
  for (Patch& patch : mesh.info.patches)
    patch.name = patch.kind == PatchKind::kOpening ? "main_wall" : "inlet_valve";
  Context context;
  expect_axis(extract_centerline(mesh.view(), {}, context));
}

TEST(MeshLines, AreThoseOfTheSurfaceTurnedInsideOut) {
  MixedMesh mesh = closed_tube();
  for (Cell<3>& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  Context context;
  const Polylines lines = extract_centerline(mesh.view(), {}, context);
  expect_axis(lines);
  EXPECT_NEAR(height_range(lines).second, kLength, 1e-6);
}

TEST(MeshLines, HaveTheSameVoxelsWhereTrianglesAreTurnedToEitherSide) {
  MixedMesh mesh = closed_tube();
  mesh.triangle_patches.assign(mesh.triangles.size(), kWallPatch);
  Context context;
  const Polylines sound = extract_centerline(mesh.view(), {}, context);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (t % 7 < 3) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);  // A seventh of the volume is left.
  const Polylines lines = extract_centerline(mesh.view(), {}, context);
  expect_axis(lines);
  EXPECT_NEAR(static_cast<double>(lines.points.size()), static_cast<double>(sound.points.size()), 2);
}

TEST(MeshLines, OfATorusAreItsCircle) {
  const fixtures::TriangleSoup torus = fixtures::torus_surface(10, 3, 96, 32);
  MixedMesh mesh;
  mesh.points = torus.points;
  mesh.triangles = torus.triangles;
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  Context context;
  const Polylines lines = extract_centerline(mesh.view(), {}, context);
  ASSERT_EQ(lines.lines.size(), 1U);
  EXPECT_EQ(lines.lines[0].front(), lines.lines[0].back());
  for (const Vec3& p : lines.points) {
    EXPECT_NEAR(p.head<2>().norm(), 10, 0.1);
    EXPECT_NEAR(p.z(), 0, 0.1);
  }
}

TEST(MeshLines, AreRefusedOfWhatEnclosesNothing) {
  Context context;
  EXPECT_THROW(static_cast<void>(extract_centerline(MixedMesh().view(), {}, context)), Error);
  MixedMesh flat;
  flat.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  flat.triangle_patches = {0, 0};
  EXPECT_THROW(static_cast<void>(extract_centerline(flat.view(), {}, context)), Error);
  EXPECT_THROW(static_cast<void>(extract_centerline(closed_tube().view(), {.voxel_mm = 1e-6}, context)),
               Error);
}

}  // namespace
}  // namespace lumesh
