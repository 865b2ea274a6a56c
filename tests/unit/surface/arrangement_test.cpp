// The outer boundary of surfaces that cross themselves, beside volumes that are known otherwise.
#include "lumesh/surface/arrangement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "fixtures/surfaces.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/repair.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

using IntegerBox = std::array<Index3, 2>;  // Lowest and highest corner.

TriangleMesh boxes_surface(const std::vector<IntegerBox>& boxes) {
  TriangleMesh surface;
  for (const auto& [low, high] : boxes)
    append_surface(fixtures::unit_cube_surface().moved([&, low = low, high = high](const Vec3& p) {
      return Vec3(low.cast<double>() + p.cwiseProduct((high - low).cast<double>()));
    }),
                   surface);
  return weld(surface.points, surface.triangles, surface.patches);
}
double enclosed_volume(const TriangleMesh& surface) {
  double volume = 0;
  for (const auto& [a, b, c] : surface.triangles)
    volume += tetrahedron_volume(Vec3::Zero(), surface.points[a], surface.points[b], surface.points[c]);
  return volume;
}
int cells_in_any(const std::vector<IntegerBox>& boxes) {
  std::set<std::array<int, 3>> cells;
  for (const auto& [low, high] : boxes)
    for (int z = low.z(); z < high.z(); ++z)
      for (int y = low.y(); y < high.y(); ++y)
        for (int x = low.x(); x < high.x(); ++x) cells.insert({x, y, z});
  return static_cast<int>(cells.size());
}
/// Edges that triangles run one way more often than the other.
int open_edges(const TriangleMesh& surface) {
  std::map<std::array<std::uint32_t, 2>, int> runs;
  for (const Cell<3>& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      runs[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  return static_cast<int>(std::ranges::count_if(runs, [](const auto& run) { return run.second != 0; }));
}

/// Boxes of whole numbers have faces in common planes, edges on edges and corners on faces.
TEST(OuterBoundary, OfBoxesOfWholeNumbersEnclosesTheCellsInAnyOfThem) {
  int made_of_all = 0;
  constexpr int kSeeds = 300;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> corner(0, 6), size(1, 5), count(2, 4);
    std::vector<IntegerBox> boxes(static_cast<std::size_t>(count(random)));
    for (auto& [low, high] : boxes) {
      low = {corner(random), corner(random), corner(random)};
      high = low + Index3(size(random), size(random), size(random));
    }
    const auto made = outer_boundary(boxes_surface(boxes));
    if (!made) continue;  // Not every degenerate case is dealt with; none may be wrong.
    ++made_of_all;
    EXPECT_NEAR(enclosed_volume(made->surface), cells_in_any(boxes), 1e-8) << "seed " << seed;
    EXPECT_EQ(open_edges(made->surface), 0) << "seed " << seed;
  }
  EXPECT_GE(made_of_all, kSeeds * 3 / 4);
  RecordProperty("made", made_of_all);
}

/// Against inclusion and exclusion: a ball of radius r whose centre lies h off a plane has a cap of known
/// volume, two balls meet in two of them.
TEST(OuterBoundary, OfTwoBallsHasTheirVolumeWithoutTheLens) {
  constexpr double kRadius = 10, kApart = 12.3;
  const fixtures::TriangleSoup ball = fixtures::icosphere(4, kRadius);
  TriangleMesh pair;
  append_surface(ball, pair);
  const double one = enclosed_volume(pair);
  append_surface(ball.moved([&](const Vec3& p) { return Vec3(p + kApart * Vec3(0.48, 0.6, 0.64)); }), pair);
  const auto made = outer_boundary(pair);
  ASSERT_TRUE(made);
  const double cap = kRadius - kApart / 2, lens = 2 * std::numbers::pi * cap * cap * (3 * kRadius - cap) / 3;
  EXPECT_NEAR(enclosed_volume(made->surface), 2 * one - lens, 0.02 * lens);
  EXPECT_EQ(open_edges(made->surface), 0);
  EXPECT_TRUE(find_self_crossings(made->surface.points, made->surface.triangles).empty());
  for (const Cell<3>& t : made->surface.triangles)  // On one of the balls, in none of them.
    for (const std::uint32_t v : t) {
      const Vec3& p = made->surface.points[v];
      EXPECT_GT(std::min(p.norm(), (p - kApart * Vec3(0.48, 0.6, 0.64)).norm()), 0.99 * kRadius);
    }
}

/// Turned boxes meet in general position, three and more at points; the share of places in any of them is
/// counted.
TEST(OuterBoundary, OfTurnedBoxesEnclosesWhatIsInAnyOfThem) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    TriangleMesh surface;
    std::vector<Eigen::Affine3d> into_box;
    for (int n = 0; n < 4; ++n) {
      const Vec3 axis = Vec3(number(random), number(random), number(random)).normalized();
      const Eigen::Affine3d to_box =
          Eigen::Translation3d(0.6 * Vec3(number(random), number(random), number(random))) *
          Eigen::AngleAxisd(3 * number(random), axis) *
          Eigen::Scaling(Vec3(1 + 0.5 * number(random), 1 + 0.5 * number(random), 1 + 0.5 * number(random))) *
          Eigen::Translation3d(-0.5, -0.5, -0.5);
      append_surface(fixtures::unit_cube_surface().moved([&](const Vec3& p) { return Vec3(to_box * p); }),
                     surface);
      into_box.push_back(to_box.inverse());
    }
    const auto made = outer_boundary(surface);
    ASSERT_TRUE(made) << "seed " << seed;
    constexpr int kSteps = 100;
    constexpr double kStep = 4.0 / kSteps;
    int inside = 0;
    for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
      const Vec3 p = kStep * Vec3(i % kSteps + 0.5, i / kSteps % kSteps + 0.5, i / kSteps / kSteps + 0.5) -
                     Vec3::Constant(2);
      inside += std::ranges::any_of(into_box, [&](const Eigen::Affine3d& to_unit) {
        const Vec3 at = to_unit * p;
        return at.minCoeff() > 0 && at.maxCoeff() < 1;
      });
    }
    EXPECT_NEAR(enclosed_volume(made->surface), inside * kStep * kStep * kStep, 0.03) << "seed " << seed;
    EXPECT_EQ(open_edges(made->surface), 0) << "seed " << seed;
  }
}

/// Edges of one lie in planes of the other, and lines of crossing pass through vertices: two square prisms
/// whose axes meet. Their union is known.
TEST(OuterBoundary, OfEqualPrismsWhoseAxesMeetIsMade) {
  TriangleMesh pair;
  for (const int along : {0, 1})
    append_surface(fixtures::unit_cube_surface().moved([&](const Vec3& p) {
      const double y = p.y() - 0.5, z = p.z() - 0.5;  // A square on its corner.
      Vec3 at(6 * p.x() - 3, y - z, y + z);
      if (along == 1) at = Vec3(-at.y(), at.x(), at.z());
      return at;
    }),
                   pair);
  const auto made = outer_boundary(pair);
  ASSERT_TRUE(made);
  // Each has the section |s| + |t| <= 1 of area 2; at height h both have widths 2 (1 - |h|), in common the
  // square.
  EXPECT_NEAR(enclosed_volume(made->surface), 2 * 12 - 4 * 2 / 3.0, 1e-8);
  EXPECT_EQ(open_edges(made->surface), 0);
}

TEST(OuterBoundary, OfASoundSurfaceIsThatSurface) {
  TriangleMesh ball;
  append_surface(fixtures::icosphere(2, 5), ball);
  const auto made = outer_boundary(ball);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->surface.triangles, ball.triangles);
  EXPECT_EQ(made->cut_triangles, 0U);
}

/// Two vessels that cross: away from the lines where they do, every triangle stays to the last bit.
TEST(LocalRepair, OpenTubesThatCrossBecomeOneAndKeepTheirOpenings) {
  const TriangleMesh tube = open_tube({.radius_mm = 2, .length_mm = 40, .around = 32});
  TriangleMesh across = tube, pair = tube;
  for (Vec3& p : across.points) p = Vec3(p.z() - 20.3, 0.8 * p.x() + 0.2, 0.8 * p.y() + 19.7);
  append_surface(across, pair);
  const RepairedSurface made = repair_locally(pair, 0.4);
  ASSERT_TRUE(made.ok()) << made.failure;
  EXPECT_EQ(made.report.components, 1U);
  EXPECT_EQ(made.report.openings, 4U);
  EXPECT_EQ(made.report.moved.distance_mm, 0);
  EXPECT_GT(made.report.cut_triangles, 0U);
  std::set<std::array<double, 9>> now;
  const auto coordinates = [](const TriangleMesh& surface, const Cell<3>& t) {
    std::array<double, 9> all;
    for (std::size_t i = 0; i < 9; ++i) all[i] = surface.points[t[i / 3]][static_cast<int>(i % 3)];
    return all;
  };
  for (const Cell<3>& t : made.surface.triangles) now.insert(coordinates(made.surface, t));
  std::size_t far = 0;
  for (const Cell<3>& t : pair.triangles) {
    const Vec3 middle = (pair.points[t[0]] + pair.points[t[1]] + pair.points[t[2]]) / 3;
    if ((middle - Vec3(0, 0, 19.7)).norm() < 4) continue;
    ++far;
    const auto& [a, b, c] = t;
    EXPECT_TRUE(now.contains(coordinates(pair, {a, b, c})) || now.contains(coordinates(pair, {b, c, a})) ||
                now.contains(coordinates(pair, {c, a, b})));
  }
  EXPECT_GT(far, pair.triangles.size() / 2);
  for (const Finding& finding : findings_of(made.surface.points, made.surface.triangles))
    EXPECT_NE(finding.severity, Severity::kFault) << finding.kind;
}

}  // namespace
}  // namespace lumesh::surfaces
