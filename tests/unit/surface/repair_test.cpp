// Surfaces with generated faults become sound, near what they were before, and no more than they need.
#include "lumesh/surface/repair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>

#include "fixtures/surfaces.hpp"
#include "generated_faults.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/surface/distance.hpp"
#include "lumesh/surface/findings.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

TriangleMesh mesh_of(const fixtures::TriangleSoup& soup) {
  return {soup.points, soup.triangles, std::vector<std::int32_t>(soup.triangles.size(), 0)};
}
double diagonal_of(const TriangleMesh& surface) {
  Box3 box;
  for (const Vec3& p : surface.points) box.extend(p);
  return box.diagonal().norm();
}
double distance_between(const TriangleMesh& a, const TriangleMesh& b) {
  const double step = diagonal_of(a) / 100;
  return std::max(farthest_from(a, TriangleTree(b.points, b.triangles), step).distance_mm,
                  farthest_from(b, TriangleTree(a.points, a.triangles), step).distance_mm);
}
/// Faults among findings, that a sound surface must not have.
std::string faults_of(const TriangleMesh& surface) {
  std::string faults;
  for (const Finding& finding : findings_of(surface.points, surface.triangles))
    if (finding.severity == Severity::kFault || finding.kind == "local_intersections" ||
        finding.kind == "inside_out" || finding.kind == "turned_triangles")
      faults += finding.kind + " ";
  return faults;
}

struct SoundShape {
  std::string name;
  TriangleMesh surface;
  std::uint64_t openings;
  std::int64_t genus;
};
std::vector<SoundShape> sound_shapes() {
  return {{"ball", mesh_of(fixtures::icosphere(4, 10)), 0, 0},
          {"torus", mesh_of(fixtures::torus_surface(10, 3, 64, 24)), 0, 1},
          {"tube", open_tube({.radius_mm = 3, .length_mm = 30, .around = 40}), 2, 0}};
}

TEST(LocalRepair, MakesGeneratedFaultsGoodWithinOnePercent) {
  int tried = 0, repaired = 0;
  for (const SoundShape& shape : sound_shapes())
    for (const std::string& kind : FaultMaker::kinds())
      for (unsigned seed = 1; seed <= 2; ++seed) {
        SCOPED_TRACE(shape.name + ", " + kind + ", seed " + std::to_string(seed));
        const RepairedSurface made =
            repair_locally(FaultMaker(shape.surface, seed).with(kind), 0.01 * diagonal_of(shape.surface));
        ++tried;
        if (!made.ok()) {
          EXPECT_TRUE(made.surface.triangles.empty());
          EXPECT_LT(made.failure_mm.norm(), 40) << "the place is on the surface";
          continue;
        }
        ++repaired;
        EXPECT_EQ(faults_of(made.surface), "");
        EXPECT_EQ(made.report.openings, shape.openings);
        EXPECT_EQ(made.report.genus, shape.genus);
        EXPECT_EQ(made.report.components, 1U);
        EXPECT_LE(distance_between(made.surface, shape.surface), 0.01 * diagonal_of(shape.surface));
      }
  EXPECT_GE(repaired, 0.95 * tried) << tried << " tried";
}

/// A cylinder of 48 sides without vertices between its ends: sharp edges, and triangles much larger than its
/// faults. Rim of the lower end from vertex 0 on, then of the upper one, then the middles of both.
TriangleMesh drum() {
  constexpr std::uint32_t kAround = 48;
  TriangleMesh drum = revolved({{3, 0}, {3, 10}}, kAround);
  drum.points.emplace_back(0, 0, 0);
  drum.points.emplace_back(0, 0, 10);
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t next = (i + 1) % kAround;
    drum.triangles.push_back({2 * kAround, next, i});
    drum.triangles.push_back({2 * kAround + 1, kAround + i, kAround + next});
  }
  drum.patches.resize(drum.triangles.size(), 0);
  return drum;
}

/// Higher than what may move: what is dropped does not count for the distance.
TEST(LocalRepair, ATriangleThatStandsOnAnEdgeIsDroppedHoweverHigh) {
  for (const SoundShape& shape : sound_shapes()) {
    SCOPED_TRACE(shape.name);
    TriangleMesh surface = shape.surface;
    const Cell<3> at = surface.triangles[surface.triangles.size() / 2];
    const Vec3 a = surface.points[at[0]], b = surface.points[at[1]], c = surface.points[at[2]];
    surface.points.push_back(0.5 * (a + b) + 5 * (b - a).cross(c - a).normalized());
    surface.triangles.push_back({at[0], at[1], static_cast<std::uint32_t>(surface.points.size() - 1)});
    surface.patches.push_back(0);
    const RepairedSurface made = repair_locally(surface, 0.01 * diagonal_of(shape.surface));
    ASSERT_TRUE(made.ok()) << made.failure;
    EXPECT_EQ(made.surface.triangles.size(), shape.surface.triangles.size());
    EXPECT_EQ(made.report.loose_triangles, 1U);
    EXPECT_LT(distance_between(made.surface, shape.surface), 1e-12);
  }
}

TEST(LocalRepair, VerticesPulledPastTheirNeighboursOnASharpEdgeArePutBack) {
  const TriangleMesh sound = drum();
  TriangleMesh one = sound, two = sound;
  one.points[0] = sound.points[1] + 0.3 * (sound.points[1] - sound.points[0]);
  std::swap(two.points[1], two.points[2]);
  for (const TriangleMesh& faulty : {one, two}) {
    const RepairedSurface made = repair_locally(faulty, 0.01 * diagonal_of(faulty));
    ASSERT_TRUE(made.ok()) << made.failure;
    EXPECT_EQ(made.report.moved_vertices, 1U);
    EXPECT_EQ(made.report.removed_triangles, 0U);
    EXPECT_EQ(made.surface.triangles.size(), sound.triangles.size());
    EXPECT_EQ(faults_of(made.surface), "");
    EXPECT_LE(distance_between(made.surface, sound), 0.01 * diagonal_of(sound));
  }
}

/// A block with square ends and kSquares x kSquares squares on each side, the first vertex at a corner.
TriangleMesh block() {
  constexpr std::uint32_t kSquares = 12, kAround = 4 * kSquares;
  std::vector<Vec2> profile;
  for (std::uint32_t row = 0; row <= kSquares; ++row) profile.emplace_back(1, 20.0 * row / kSquares);
  TriangleMesh block = revolved(profile, kAround);
  const std::array<Vec2, 5> corners = {Vec2(10, 0), Vec2(0, 10), Vec2(-10, 0), Vec2(0, -10), Vec2(10, 0)};
  for (std::size_t v = 0; v < block.points.size(); ++v) {
    const std::size_t side = v % kAround / kSquares;
    const double share = static_cast<double>(v % kSquares) / kSquares;
    block.points[v].head<2>() = corners[side] + share * (corners[side + 1] - corners[side]);
  }
  block.points.emplace_back(0, 0, 0);
  block.points.emplace_back(0, 0, 20);
  const auto middle = static_cast<std::uint32_t>(block.points.size()) - 2;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t next = (i + 1) % kAround;
    block.triangles.push_back({middle, next, i});
    block.triangles.push_back({middle + 1, kAround * kSquares + i, kAround * kSquares + next});
  }
  block.patches.resize(block.triangles.size(), 0);
  return block;
}

TEST(LocalRepair, ACornerPulledFarIsPutBackWhollyAndTold) {
  const TriangleMesh sound = block();
  TriangleMesh faulty = sound;
  faulty.points[0] = sound.points[1] + 0.3 * (sound.points[1] - sound.points[0]);
  const double asked_mm = 0.01 * diagonal_of(sound);
  ASSERT_GT(distance_between(faulty, sound), 1.5 * asked_mm);
  const RepairedSurface made = repair_locally(faulty, asked_mm);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(faults_of(made.surface), "");
  EXPECT_LE(distance_between(made.surface, sound), asked_mm);
  EXPECT_EQ(made.report.far_vertices, 1U);
  EXPECT_GT(made.report.put_back.distance_mm, asked_mm);
  EXPECT_LE(made.report.moved.distance_mm, asked_mm);
}

TEST(LocalRepair, WhatCrossesAmongLargeTrianglesIsTakenOutInPieces) {
  const TriangleMesh sound = drum();
  TriangleMesh faulty = sound;  // Four in the opposite order: none can be put back by itself.
  for (std::uint32_t v = 0; v < 4; ++v) faulty.points[v] = sound.points[3 - v];
  const RepairedSurface made = repair_locally(faulty, 0.01 * diagonal_of(sound));
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_GT(made.report.removed_triangles, 0U);
  EXPECT_EQ(faults_of(made.surface), "");
  EXPECT_LE(distance_between(made.surface, sound), 0.01 * diagonal_of(sound));
}

TEST(LocalRepair, HolesThatTouchAtAPointAreFilledWithoutTakingAnythingOut) {
  const TriangleMesh ball = mesh_of(fixtures::icosphere(3, 10));
  TriangleMesh faulty = ball;
  std::vector<std::uint32_t> at_first;
  const std::uint32_t v = ball.triangles[0][0];
  for (std::uint32_t t = 0; t < ball.triangles.size(); ++t)
    if (std::ranges::count(ball.triangles[t], v) > 0) at_first.push_back(t);
  std::vector<std::uint32_t> apart = {at_first[0]};
  for (const std::uint32_t t : at_first) {
    const auto shared = std::ranges::count_if(ball.triangles[t], [&](std::uint32_t w) {
      return std::ranges::count(ball.triangles[at_first[0]], w) > 0;
    });
    if (shared == 1 && apart.size() < 2) apart.push_back(t);
  }
  without_triangles(faulty, apart);
  const RepairedSurface made = repair_locally(faulty, 0.01 * diagonal_of(ball));
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.holes, 2U);
  EXPECT_EQ(made.report.new_triangles, 2U);
  EXPECT_EQ(made.report.removed_triangles, 0U);
  EXPECT_EQ(made.surface.triangles.size(), ball.triangles.size());
  EXPECT_EQ(faults_of(made.surface), "");
}

TEST(LocalRepair, LeavesASoundSurfaceAsItIs) {
  for (const SoundShape& shape : sound_shapes()) {
    const RepairedSurface made = repair_locally(shape.surface, 0.1);
    ASSERT_TRUE(made.ok()) << shape.name << made.failure;
    EXPECT_EQ(made.report.new_triangles, 0U);
    EXPECT_EQ(made.report.moved.distance_mm, 0);
    const TriangleMesh same = weld(shape.surface.points, shape.surface.triangles, {});
    EXPECT_EQ(made.surface.points, same.points) << shape.name;
    EXPECT_EQ(made.surface.triangles, same.triangles) << shape.name;
  }
}

TEST(LocalRepair, ATornEndStaysOpen) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 30, .around = 40});
  std::erase_if(tube.triangles, [&](const Cell<3>& t) {
    const Vec3 middle = (tube.points[t[0]] + tube.points[t[1]] + tube.points[t[2]]) / 3;
    return (middle - Vec3(3, 0, 30)).norm() < 2;
  });
  tube.patches.resize(tube.triangles.size());
  const RepairedSurface made = repair_locally(tube, 0.3);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.openings, 2U);
  EXPECT_EQ(made.report.holes, 0U);
}

TEST(LocalRepair, EndsClippedByHandWhoseTrianglesHangAtPointsStayOpen) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    TriangleMesh tube = open_tube({.radius_mm = 2, .length_mm = 30, .around = 40});
    std::mt19937 random(seed);
    std::erase_if(tube.triangles, [&](const Cell<3>& t) {
      const double z = (tube.points[t[0]] + tube.points[t[1]] + tube.points[t[2]]).z() / 3;
      return (z < 1 || z > 29) && random() % 5 < 3;
    });
    tube.patches.resize(tube.triangles.size());
    const RepairedSurface made = repair_locally(tube, 0.01 * diagonal_of(tube));
    ASSERT_TRUE(made.ok()) << made.failure;
    EXPECT_EQ(made.report.openings, 2U);
    EXPECT_EQ(made.report.components, 1U);
    EXPECT_EQ(faults_of(made.surface), "");
  }
}

TEST(LocalRepair, ATriangleWithoutAreaGivesWayWithoutAnyMove) {
  TriangleMesh cube = mesh_of(fixtures::unit_cube_surface());
  const auto middle = static_cast<std::uint32_t>(cube.points.size());
  const Cell<3> t = cube.triangles.back();
  cube.points.push_back((cube.points[t[2]] + cube.points[t[0]]) / 2);
  cube.triangles.back() = {t[0], t[1], middle};
  cube.triangles.push_back({t[1], t[2], middle});
  cube.triangles.push_back({t[2], t[0], middle});
  cube.patches.resize(cube.triangles.size(), 0);
  const RepairedSurface made = repair_locally(cube, 0.01);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.flipped_edges, 1U);
  EXPECT_EQ(made.report.removed_triangles, 0U);
  EXPECT_TRUE(findings_of(made.surface.points, made.surface.triangles).empty());
  EXPECT_LT(distance_between(made.surface, cube), 1e-12);
}

TEST(LocalRepair, TrianglesKeepTheirPatchesAndFillingsTakeThoseAround) {
  TriangleMesh ball = mesh_of(fixtures::icosphere(4, 10));
  for (std::size_t t = 0; t < ball.triangles.size(); ++t)
    ball.patches[t] = ball.points[ball.triangles[t][0]].z() > 0 ? 7 : 3;
  const RepairedSurface made = repair_locally(FaultMaker(ball, 5).with_holes(), 0.3);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_GT(made.report.new_triangles, 0U);
  for (std::size_t t = 0; t < made.surface.triangles.size(); ++t) {
    const auto& [a, b, c] = made.surface.triangles[t];
    const double z = (made.surface.points[a] + made.surface.points[b] + made.surface.points[c]).z() / 3;
    if (std::abs(z) > 4) {
      EXPECT_EQ(made.surface.patches[t], z > 0 ? 7 : 3);
    }
  }
}

TEST(LocalRepair, BallsThatCrossBecomeOneOfWhichAllLiesOnThem) {
  TriangleMesh pair = mesh_of(fixtures::icosphere(3, 10));
  append_surface(fixtures::icosphere(3, 10).moved([](const Vec3& p) { return Vec3(p + Vec3(12, 0.1, 0)); }),
                 pair);
  const RepairedSurface made = repair_locally(pair, 0.01 * diagonal_of(pair));
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.components, 1U);
  EXPECT_EQ(made.report.genus, 0);
  EXPECT_EQ(made.report.moved.distance_mm, 0);
  EXPECT_GT(made.report.cut_triangles, 50U);
  EXPECT_EQ(faults_of(made.surface), "");
  for (const Vec3& p : made.surface.points)
    EXPECT_NEAR(std::min(p.norm(), (p - Vec3(12, 0.1, 0)).norm()), 10, 0.1);
}

/// A tube in two pieces of other tessellations, whose vertices at the seam lie on edges of the other piece.
TriangleMesh tube_with_seam(std::uint32_t around, std::uint32_t around_above) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 10, .around = around});
  TriangleMesh above = open_tube({.radius_mm = 3, .length_mm = 12, .around = around_above});
  for (Vec3& p : above.points) p.z() += 10;
  append_surface(above, tube);
  return tube;
}

TEST(LocalRepair, PiecesThatDoNotMatchAtASeamAreJoined) {
  for (const auto& [around, around_above] : {std::pair(48U, 36U), std::pair(40U, 40U), std::pair(60U, 24U)}) {
    TriangleMesh given = tube_with_seam(around, around_above);
    for (Vec3& p : given.points)  // A gap, too, where all vertices match.
      if (p.z() > 10.01) p.z() += 0.001;
    const RepairedSurface made = repair_locally(given, 0.3);
    ASSERT_TRUE(made.ok()) << made.failure;
    EXPECT_EQ(made.report.components, 1U);
    EXPECT_EQ(made.report.openings, 2U);
    EXPECT_EQ(made.report.genus, 0);
    EXPECT_EQ(faults_of(made.surface), "");
    EXPECT_LT(distance_between(made.surface, given), 0.08);  // Sagittae of the coarser piece's edges: 0.025.
  }
}

/// Each of its faces has points of its own, and other ones than the next one has on the edge between them.
TriangleMesh box_of_faces(std::uint32_t squares, std::uint32_t squares_beside) {
  TriangleMesh box;
  for (int axis = 0; axis < 3; ++axis)
    for (const double end : {0.0, 1.0}) {
      const std::uint32_t across = axis == 2 ? squares_beside : squares;
      const auto first = static_cast<std::uint32_t>(box.points.size());
      const TriangleMesh sheet = square_sheet(across);
      for (const Vec3& p : sheet.points) {
        Vec3 at;
        at[axis] = end;
        at[(axis + 1) % 3] = p.x() / across;
        at[(axis + 2) % 3] = p.y() / across;
        box.points.push_back(at);
      }
      for (const auto& [a, b, c] : sheet.triangles)
        box.triangles.push_back({a + first, (end > 0 ? b : c) + first, (end > 0 ? c : b) + first});
    }
  box.patches.assign(box.triangles.size(), 0);
  return box;
}

/// An assertion of the exact predicates ended it before: vertices of the seams lie at one place.
TEST(LocalRepair, FacesThatDoNotMatchAtTheEdgesOfABoxAreJoined) {
  for (const std::uint32_t squares : {3U, 4U, 7U}) {
    const TriangleMesh given = box_of_faces(squares, 5);
    const RepairedSurface made = repair_locally(given, 0.02);
    ASSERT_TRUE(made.ok()) << made.failure;
    EXPECT_EQ(made.report.components, 1U);
    EXPECT_EQ(made.report.openings, 0U);
    EXPECT_EQ(faults_of(made.surface), "");
    EXPECT_LT(distance_between(made.surface, given), 1e-9);
  }
}

/// Rims nearer to each other than a quarter of their edges, across which no wall goes on.
TEST(LocalRepair, EndsOfVesselsSideBySideAreNoSeam) {
  TriangleMesh pair = open_tube({.radius_mm = 3, .length_mm = 12, .around = 40}), beside = pair;
  for (Vec3& p : beside.points) p.x() += 6.05;
  append_surface(beside, pair);
  const RepairedSurface made = repair_locally(pair, 0.3);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.seam_vertices, 0U);
  EXPECT_EQ(made.report.openings, 4U);
  EXPECT_EQ(made.surface.triangles.size(), pair.triangles.size());
}

/// Both copies of the face between two cubes go.
TEST(LocalRepair, CubesThatShareAFaceBecomeOne) {
  TriangleMesh pair = mesh_of(fixtures::unit_cube_surface());
  const auto offset = static_cast<std::uint32_t>(pair.points.size());
  for (std::uint32_t v = 0; v < offset; ++v)
    pair.points.emplace_back(2 - pair.points[v].x(), pair.points[v].y(), pair.points[v].z());
  const std::vector<Cell<3>> first = pair.triangles;
  for (const auto& [a, b, c] : first) pair.triangles.push_back({a + offset, c + offset, b + offset});
  pair.patches.resize(pair.triangles.size(), 0);
  const RepairedSurface made = repair_locally(pair, 0.05);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.shared_triangles, 4U);
  EXPECT_EQ(made.surface.triangles.size(), 20U);
  EXPECT_EQ(made.report.components, 1U);
  EXPECT_EQ(faults_of(made.surface), "");
}

TEST(LocalRepair, WallsOfTwoSkinsStay) {
  // A hollow ball whose wall is thinner than what may move: its inner skin points inwards and is no copy.
  TriangleMesh ball = mesh_of(fixtures::icosphere(3, 10));
  append_surface(fixtures::icosphere(3, 9.9).reversed(), ball);
  const RepairedSurface made = repair_locally(ball, 0.3);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.components, 2U);
  EXPECT_EQ(made.surface.triangles.size(), ball.triangles.size());
}

}  // namespace
}  // namespace lumesh::surfaces
