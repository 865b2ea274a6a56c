#include "lumesh/layers/layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stop_token>
#include <string_view>

#include "layer_fixtures.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fixtures::area_of;
using fixtures::ball;
using fixtures::between;
using fixtures::copy_of;
using fixtures::expect_conforming;
using fixtures::Faces;
using fixtures::grown;
using fixtures::kPi;
using fixtures::kTubeRadius;
using fixtures::meshed;
using fixtures::near_balls;
using fixtures::random_blobs;
using fixtures::tube;
using fixtures::volume_of;

TEST(Layers, OnABallFillAShell) {
  const double radius = 15, thickness = 3;
  const TetMesh mesh = ball(radius);
  const LayerResult result = grown(mesh, {.first_height = 0.5, .count = 4, .thickness = thickness});
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  ASSERT_EQ(report.labels.size(), 2u);
  const double inner = volume_of(result.mesh, 1), real = std::cbrt(inner / (4.0 / 3 * kPi));
  EXPECT_NEAR(
      volume_of(result.mesh, 2) / (4.0 / 3 * kPi * (std::pow(real + thickness, 3) - std::pow(real, 3))), 1,
      0.01);
  EXPECT_GT(result.report.complete(), 0.999);
  EXPECT_EQ(result.report.layers, 4);
  EXPECT_EQ(result.report.cells, 3 * 4 * mesh.boundary_faces().triangles.size());
  EXPECT_NEAR(result.report.patches.at(0).achieved_mm, thickness, 0.02 * thickness);
}

TEST(Layers, TheFirstHeightHolds) {
  const double radius = 15, first = 0.4;
  const TetMesh mesh = ball(radius);
  const Vec3 centre = Vec3::Constant(0.5 * (2 * radius + 7));
  const LayerResult result = grown(mesh, {.first_height = first, .growth = 1.3, .count = 3});
  const std::size_t columns = (result.mesh.points.size() - mesh.vertex_count()) / 3;
  double sum = 0;
  for (std::size_t v = 0; v < columns; ++v) {
    const Vec3& lower = result.mesh.points[mesh.vertex_count() + 3 * v];
    const Vec3& upper = result.mesh.points[mesh.vertex_count() + 3 * v + 1];
    const double second = (upper - centre).norm() - (lower - centre).norm();
    EXPECT_NEAR(second, 1.3 * first, 0.03 * first);
    sum += second;
  }
  EXPECT_NEAR(sum / static_cast<double>(columns), 1.3 * first, 0.01 * first);
  EXPECT_NEAR(result.report.heights.at(2), 1.69 * first, 1e-12);
}

TEST(Layers, EndFlushInThePlaneOfOpenings) {
  const TetMesh mesh = tube();
  const LayerResult result = grown(mesh, {.first_height = 1, .growth = 1, .count = 3});
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_GT(result.report.complete(), 0.999);
  double low = 1e9, high = -1e9;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    low = std::min(low, mesh.point(VertexId(v)).z());
    high = std::max(high, mesh.point(VertexId(v)).z());
  }
  int rings = 0;
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) {
    const std::string& name =
        result.mesh.info.patches[static_cast<std::size_t>(result.mesh.triangle_patches[t])].name;
    if (!name.ends_with("_layer")) continue;
    ++rings;
    for (const std::uint32_t v : result.mesh.triangles[t]) {
      const double z = result.mesh.points[v].z();
      EXPECT_NEAR(std::min(std::abs(z - low), std::abs(z - high)), 0, 1e-9);
    }
  }
  EXPECT_GT(rings, 100);
  for (const Patch& patch : result.mesh.info.patches)
    if (patch.name.ends_with("_layer")) {
      EXPECT_NEAR(area_of(result.mesh, patch.name) / (kPi * (13 * 13 - 10 * 10)), 1, 0.03) << patch.name;
    }
}

/// Layers of the lumen itself end in its openings, which stay one patch each.
TEST(Layers, OfTheLumenBelongToItsOpenings) {
  const TetMesh mesh = tube();
  const double section = area_of(grown(mesh, {.first_height = 1, .count = 1}).mesh, "inlet_1");
  for (const LayerCells cells : {LayerCells::kTetrahedra, LayerCells::kPrisms}) {
    const auto opening_of = [&](LayerOptions options) {
      options.cells = cells;
      const LayerResult result = grown(mesh, options);
      expect_conforming(result.mesh);
      const bool has_ring = std::any_of(result.mesh.info.patches.begin(), result.mesh.info.patches.end(),
                                        [](const Patch& patch) { return patch.name == "inlet_1_layer"; });
      return std::pair(area_of(result.mesh, "inlet_1"), has_ring);
    };
    const auto inward = opening_of({.side = LayerSide::kInward, .first_height = 0.5, .count = 2});
    EXPECT_NEAR(inward.first / section, 1, 1e-9);
    EXPECT_FALSE(inward.second);
    const auto split =
        opening_of({.side = LayerSide::kInward, .first_height = 0.5, .count = 2, .splits_openings = true});
    EXPECT_LT(split.first / section, 0.9);
    EXPECT_TRUE(split.second);
    const auto outward = opening_of({.first_height = 1, .growth = 1, .count = 3, .label = 1});
    EXPECT_NEAR(outward.first / (kPi * 13 * 13), 1, 0.03);
    EXPECT_FALSE(outward.second);
  }
}

TEST(Layers, EndAtAPlaneOfSymmetryAsAtAnOpening) {
  TetMesh mesh = tube();
  for (Patch& patch : mesh.info().patches)
    if (patch.name == "inlet_1") patch.kind = PatchKind::kSymmetry;
  const LayerResult result =
      grown(mesh, {.side = LayerSide::kInward, .first_height = 0.5, .count = 2, .splits_openings = true});
  const auto ring = std::find_if(result.mesh.info.patches.begin(), result.mesh.info.patches.end(),
                                 [](const Patch& patch) { return patch.name == "inlet_1_layer"; });
  ASSERT_NE(ring, result.mesh.info.patches.end());
  EXPECT_EQ(ring->kind, PatchKind::kSymmetry);
}

TEST(Layers, OfPrismsConformAndHaveTheirQuadrilateralsInRings) {
  const TetMesh mesh = tube();
  const LayerResult result = grown(mesh, {.first_height = 1, .count = 2, .cells = LayerCells::kPrisms});
  expect_conforming(result.mesh);
  EXPECT_EQ(result.mesh.prisms.size(), result.report.cells);
  EXPECT_GT(result.mesh.quadrilaterals.size(), 50u);
}

TEST(Layers, BetweenTwoPartsShareTheRoom) {
  const TetMesh mesh = near_balls();  // Layers of 5 mm cannot fit.
  const LayerResult result = grown(mesh, {.first_height = 1, .growth = 1, .count = 5});
  ASSERT_TRUE(validate(result.mesh.view()).ok()) << validate(result.mesh.view()).text();
  const LayerCoverage& wall = result.report.patches.at(0);
  EXPECT_LT(wall.complete, 0.97);
  EXPECT_GT(wall.complete, 0.5);
  EXPECT_FALSE(wall.worst.empty());
  double shares = 0;
  for (std::size_t i = 1; i < kLayerLimits; ++i) shares += wall.limited[i];
  EXPECT_NEAR(shares, 1 - wall.complete, 1e-9);
}

TEST(Layers, AreTheSameForEveryNumberOfThreads) {
  const TetMesh mesh = tube();
  for (const LayerSide side : {LayerSide::kOutward, LayerSide::kInward}) {
    const auto with = [&](int threads) {
      const parallel::ThreadLimit limit(threads);
      return grown(mesh, {.side = side, .first_height = side == LayerSide::kInward ? 0.5 : 2.0, .count = 6})
          .mesh;
    };
    const MixedMesh one = with(1);
    for (const int threads : {2, 8}) {
      const MixedMesh many = with(threads);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.tetrahedra, many.tetrahedra);
    }
  }
}

TEST(Layers, InATubeFillItWithWhatIsLeft) {
  const TetMesh mesh = tube();
  const double volume = validate(mesh).labels.at(0).volume, first = 0.4;
  for (const LayerCells cells : {LayerCells::kTetrahedra, LayerCells::kPrisms}) {
    const LayerResult result = grown(
        mesh, {.side = LayerSide::kInward, .first_height = first, .growth = 1.2, .count = 4, .cells = cells});
    expect_conforming(result.mesh);
    EXPECT_GT(result.report.complete(), 0.98);
    const double thickness = first * (1 + 1.2 + 1.44 + 1.728);
    EXPECT_NEAR(result.report.patches.at(0).achieved_mm, thickness, 0.02 * thickness);
    if (cells == LayerCells::kPrisms) continue;
    const ValidationReport report = validate(result.mesh.view());
    ASSERT_TRUE(report.ok()) << report.text();
    const double core = volume_of(result.mesh, 1), layers = volume_of(result.mesh, 2);
    EXPECT_NEAR((core + layers) / volume, 1, 1e-9);
    const double inner = kTubeRadius - thickness;
    EXPECT_NEAR(core / volume, inner * inner / (kTubeRadius * kTubeRadius), 0.02);
    EXPECT_NEAR(area_of(result.mesh, "wall"),
                area_of(grown(mesh, {.first_height = 1, .count = 1}).mesh, "wall"), 1e-6);
  }
}

/// As a curved patch, a flat one keeps all its triangles; its rim, where the tube bends, stays unlayered.
TEST(Layers, InwardsTheWallKeepsItsTrianglesToTheLastBit) {
  using Place = std::array<double, 3>;
  const auto triangles_of = [](const MeshView& view, std::string_view patch) {
    std::set<std::array<Place, 3>> triangles;
    for (std::size_t i = 0; i < view.triangles.size(); ++i) {
      if (view.info->patches[static_cast<std::size_t>(view.triangle_patches[i])].name != patch) continue;
      std::array<Place, 3> places;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = view.points[view.triangles[i][k]];
        places[k] = {p[0], p[1], p[2]};
      }
      std::sort(places.begin(), places.end());
      triangles.insert(places);
    }
    return triangles;
  };
  const TetMesh mesh = tube();
  const BoundaryFaces faces = mesh.boundary_faces();
  const auto before = triangles_of(mesh.view(faces), "wall");
  ASSERT_GT(before.size(), 100u);
  const LayerResult result =
      grown(mesh, {.side = LayerSide::kInward, .first_height = 0.4, .growth = 1.2, .count = 4});
  EXPECT_TRUE(triangles_of(result.mesh.view(), "wall") == before);
  const auto wall = std::ranges::find(result.mesh.info.patches, "wall", &Patch::name);
  ASSERT_NE(wall, result.mesh.info.patches.end());
  EXPECT_EQ(wall->labels, (std::array<Label, 2>{2, kBackground})) << "behind it are the layers now";
}

TEST(Layers, OnAFlatPatchGrowWithinItsRim) {
  const TetMesh mesh = tube();
  const std::string cap = mesh.info().patches.at(1).name;
  const LayerResult result =
      grown(mesh, {.patches = {cap}, .side = LayerSide::kInward, .first_height = 0.5, .count = 3});
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  expect_conforming(result.mesh);
  const MixedMesh before = copy_of(mesh);
  EXPECT_NEAR(area_of(result.mesh, cap), area_of(before, cap), 1e-9 * area_of(before, cap));
  const LayerCoverage& of_cap = result.report.patches.at(0);
  EXPECT_GT(of_cap.complete, 0.2);
  EXPECT_GT(of_cap.mean_layers, 1.5) << "one more from ring to ring";
  EXPECT_GT(of_cap.limited[static_cast<std::size_t>(LayerLimit::kRim)], 0.01);
  EXPECT_NEAR(volume_of(result.mesh, 1) + volume_of(result.mesh, 2), volume_of(before, 1),
              1e-9 * volume_of(before, 1));
}

/// As in meshes of others, whose openings are flat to some digits, or were cut a little askew.
TEST(Layers, EndAtOpeningsThatAreNearlyFlat) {
  MixedMesh crooked = copy_of(tube());
  for (Vec3& p : crooked.points) p.z() += 0.002 * (p.x() - 19.5) * (p.y() - 19.5);
  const LayerResult result =
      grown(TetMesh::build(crooked.view()), {.side = LayerSide::kInward, .first_height = 0.4, .count = 4});
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_GT(result.report.complete(), 0.98);
  EXPECT_NEAR((volume_of(result.mesh, 1) + volume_of(result.mesh, 2)) / volume_of(crooked, 1), 1, 1e-3);
}

/// Vertices are told by their bits, and zeros of both signs are one place.
TEST(Layers, InATubeThroughNegativeZeros) {
  MixedMesh shifted = copy_of(tube());
  const std::uint32_t of_wall = shifted.triangles.at(0)[0];
  const Vec3 there = shifted.points[of_wall];
  for (Vec3& p : shifted.points) p -= there;
  shifted.points[of_wall] = Vec3::Constant(-0.0);
  const LayerResult result =
      grown(TetMesh::build(shifted.view()), {.side = LayerSide::kInward, .first_height = 0.4, .count = 3});
  EXPECT_TRUE(validate(result.mesh.view()).ok());
  EXPECT_GT(result.report.complete(), 0.98);
}

/// As solvers want it that know one fluid.
TEST(Layers, OfTheMeshsOwnLabelAreOneRegionWithIt) {
  const TetMesh mesh = tube();
  const double volume = validate(mesh).labels.at(0).volume;
  for (const LayerSide side : {LayerSide::kInward, LayerSide::kOutward}) {
    const LayerResult result = grown(mesh, {.side = side, .first_height = 0.4, .count = 3, .label = 1});
    const ValidationReport report = validate(result.mesh.view());
    ASSERT_TRUE(report.ok()) << report.text();
    expect_conforming(result.mesh);
    ASSERT_EQ(report.labels.size(), 1u);
    if (side == LayerSide::kInward) {
      EXPECT_NEAR(report.labels[0].volume / volume, 1, 1e-9);
      EXPECT_EQ(area_of(result.mesh, "layer_inner"), 0);
    }
    EXPECT_FALSE(result.mesh.info.label_names.contains(1));
  }
}

/// Once begun they are grown to their end: half of it would be worse layers, not fewer.
TEST(Layers, AreTheSameWhoeverCancels) {
  const TetMesh mesh = tube();
  const LayerOptions options = {.side = LayerSide::kInward, .first_height = 0.5, .count = 4};
  std::stop_source source;
  source.request_stop();
  Context cancelled({}, {}, source.get_token());
  const MixedMesh wanted = grown(mesh, options).mesh, found = grow_layers(mesh, options, cancelled).mesh;
  EXPECT_EQ(wanted.points, found.points);
  EXPECT_EQ(wanted.tetrahedra, found.tetrahedra);
}

/// Two vessels that touch in a point without sharing it.
TEST(Layers, InwardsVerticesAtOnePlaceAreRefused) {
  MixedMesh both = copy_of(ball(5));
  const std::size_t count = both.points.size();
  std::size_t right = 0;
  for (std::size_t v = 1; v < count; ++v)
    if (both.points[v].x() > both.points[right].x()) right = v;
  const MixedMesh one = both;
  for (const Vec3& p : one.points) {  // Turned by half about an axis through the rightmost point.
    const Vec3 from = p - one.points[right];
    both.points.push_back(one.points[right] + Vec3(-from.x(), -from.y(), from.z()));
  }
  const auto shifted = static_cast<std::uint32_t>(count);
  for (Cell<4> c : one.tetrahedra) {
    for (std::uint32_t& v : c) v += shifted;
    both.tetrahedra.push_back(c);
    both.tetrahedron_labels.push_back(1);
  }
  for (Cell<3> c : one.triangles) {
    for (std::uint32_t& v : c) v += shifted;
    both.triangles.push_back(c);
    both.triangle_patches.push_back(0);
  }
  try {
    grown(TetMesh::build(both.view()), {.side = LayerSide::kInward, .first_height = 0.2, .count = 2});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(error.what()).find("two vertices of the surface lie at"), std::string::npos);
  }
}

TEST(Layers, ThickerThanTheVesselLeaveRoomWithin) {
  const TetMesh mesh = tube();
  const LayerResult result =
      grown(mesh, {.side = LayerSide::kInward, .first_height = 4, .growth = 1, .count = 5});
  const ValidationReport report = validate(result.mesh.view());
  ASSERT_TRUE(report.ok()) << report.text();
  EXPECT_LT(result.report.complete(), 0.01);
  EXPECT_GT(volume_of(result.mesh, 1), 0);
  EXPECT_GT(result.report.patches.at(0).achieved_mm, 2);
}

TEST(Layers, HeightsMayBeSharesOfTheRadiusOrOfEdges) {
  const TetMesh mesh = tube();
  const LayerResult of_radius =
      grown(mesh, {.first_height = 0.1, .growth = 1, .count = 2, .scale = HeightScale::kRadius});
  EXPECT_NEAR(of_radius.report.patches.at(0).achieved_mm, 0.2 * kTubeRadius, 0.1 * kTubeRadius * 0.2);
  const LayerResult of_edge =
      grown(mesh, {.first_height = 0.5, .growth = 1, .count = 1, .scale = HeightScale::kEdge});
  EXPECT_GT(of_edge.report.patches.at(0).achieved_mm, 0.5);  // Edges are about 2.5 mm long.
  EXPECT_LT(of_edge.report.patches.at(0).achieved_mm, 2);
}

/// Blobs of balls, with heights from next to nothing to more than the object.
TEST(Layers, OnRandomShapesAreAlwaysValidAndTellWhatTheyAre) {
  std::mt19937 random(7);
  for (int round = 0; round < 12; ++round) {
    const TetMesh mesh = random_blobs(random);
    const double height = std::pow(10, between(-3, 0.7, random));
    const LayerSide side = round % 2 == 0 ? LayerSide::kOutward : LayerSide::kInward;
    const LayerResult result = grown(
        mesh,
        {.side = side, .first_height = height, .growth = between(1, 1.5, random), .count = 1 + round % 5});
    const ValidationReport report = validate(result.mesh.view());
    ASSERT_TRUE(report.ok()) << "round " << round << ", height " << height << "\n" << report.text();
    ASSERT_EQ(result.report.patches.size(), 1u);
    const LayerCoverage& wall = result.report.patches[0];
    EXPECT_GE(wall.complete, 0);
    EXPECT_LE(wall.achieved_mm, wall.wanted_mm * (1 + 1e-12));
    EXPECT_LE(wall.unlayered + wall.complete, 1 + 1e-12);
    if (round % 3 == 0)
      expect_conforming(
          grown(mesh, {.side = side, .first_height = height, .count = 2, .cells = LayerCells::kPrisms}).mesh);
  }
}

TEST(Layers, RefuseWhatCannotBe) {
  const TetMesh mesh = ball(6);
  const auto fault = [&](const LayerOptions& options) -> std::string {
    try {
      grown(mesh, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), options.first_height < 0 ? ErrorKind::kUsage : ErrorKind::kBadInput);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(fault({.patches = {"door"}, .first_height = 1, .count = 1}).find("no patch door; there are wall"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 0, .count = 1}).find("`first_height` is missing"), std::string::npos);
  EXPECT_NE(fault({.first_height = -1, .count = 1}).find("`first_height` must be greater than 0"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1e6, .count = 1}).find("more than the surface is wide"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1, .growth = 1}).find("do not grow never become as high"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1, .short_of_room = ShortOfRoom::kShrink}).find("`short_of_room` shrink"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1, .growth = 0.5, .thickness = 3}).find("growth below 1"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1, .count = 5, .thickness = 0.5}).find("less than the first"),
            std::string::npos);
  EXPECT_NE(fault({.first_height = 1e-9, .growth = 1, .thickness = 3}).find("200 layers"), std::string::npos);
}

}  // namespace
}  // namespace lumesh
