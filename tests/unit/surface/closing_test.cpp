#include "lumesh/surface/closing.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/rims.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

using fixtures::icosphere;
using fixtures::torus_surface;
using fixtures::TriangleSoup;

constexpr double kPi = std::numbers::pi;

double volume_of(const TriangleMesh& surface) {
  double six = 0;
  for (const auto& [a, b, c] : surface.triangles)
    six += surface.points[a].dot(surface.points[b].cross(surface.points[c]));
  return six / 6;
}

/// Closed, turned alike, without crossings; every cap in one plane, with a patch of its own.
void expect_sound(const ClosedSurfaceMade& made) {
  const EdgeNeighbours neighbours = edge_neighbours(made.surface.triangles);
  for (const auto& beside : neighbours)
    for (const std::uint32_t t : beside) ASSERT_LT(t, kCrowdedEdge);
  TriangleMesh turned = made.surface;
  turn_alike(turned);
  EXPECT_EQ(turned.triangles, made.surface.triangles);
  EXPECT_GT(volume_of(made.surface), 0);
  EXPECT_TRUE(find_self_crossings(made.surface.points, made.surface.triangles).empty());
  for (const ClosedRim& rim : made.rims) {
    if (!rim.is_opening) continue;
    std::size_t count = 0;
    for (std::size_t t = 0; t < made.surface.triangles.size(); ++t) {
      if (made.surface.patches[t] != rim.patch) continue;
      ++count;
      for (const std::uint32_t v : made.surface.triangles[t])
        EXPECT_LT(std::abs(rim.normal.dot(made.surface.points[v] - rim.centre_mm)),
                  1e-12 * rim.given.radius_mm);
    }
    EXPECT_EQ(count, rim.triangles);
  }
}

ClosedSurfaceMade closed(const TriangleMesh& open) {
  ClosedSurfaceMade made = close_surface(open.points, open.triangles, open.patches, 1);
  expect_sound(made);
  return made;
}

std::size_t openings_of(const ClosedSurfaceMade& made) {
  return static_cast<std::size_t>(
      std::count_if(made.rims.begin(), made.rims.end(), [](const ClosedRim& rim) { return rim.is_opening; }));
}

const ClosedRim& upper(const ClosedSurfaceMade& made) {
  return *std::max_element(made.rims.begin(), made.rims.end(), [](const ClosedRim& a, const ClosedRim& b) {
    return a.centre_mm.z() < b.centre_mm.z();
  });
}

TEST(Closing, APlanarEndIsCappedWithoutATouchOfTheWall) {
  const TriangleMesh tube = open_tube({});
  const ClosedSurfaceMade made = closed(tube);
  ASSERT_EQ(openings_of(made), 2U);
  for (const ClosedRim& rim : made.rims) {
    EXPECT_EQ(rim.cut_off_mm, 0);
    EXPECT_LT(rim.moved_mm, 1e-13);
    EXPECT_NEAR(rim.area_mm2, 0.5 * 48 * 9 * std::sin(2 * kPi / 48), 1e-9);
    EXPECT_GT(rim.smallest_angle_deg, 28);
    EXPECT_NEAR(std::abs(rim.normal.z()), 1, 1e-12);
  }
  // The wall comes first, as it was.
  for (std::size_t t = 0; t < tube.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LT(
          (made.surface.points[made.surface.triangles[t][i]] - tube.points[tube.triangles[t][i]]).norm(),
          1e-13);
}

TEST(Closing, ASlantedEndStaysSlanted) {
  TriangleMesh tube = open_tube({});
  for (Vec3& p : tube.points) p.z() += 0.4 * p.x() * p.z() / 20;
  const ClosedSurfaceMade made = closed(tube);
  ASSERT_EQ(openings_of(made), 2U);
  for (const ClosedRim& rim : made.rims) EXPECT_EQ(rim.cut_off_mm, 0);
}

TEST(Closing, TurnedInsideOutOrAtRandomMakesNoDifference) {
  TriangleMesh tube = open_tube({});
  const double volume = volume_of(closed(tube).surface);
  for (Cell<3>& t : tube.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(volume_of(closed(tube).surface), volume, 1e-9);
  std::mt19937 random(3);
  for (Cell<3>& t : tube.triangles)
    if (random() % 2 == 0) std::swap(t[0], t[1]);
  EXPECT_NEAR(volume_of(closed(tube).surface), volume, 1e-9);
}

struct BentEnd {
  const char* name;
  double max_cut_off_mm;  // Of a tube of radius 3.
  std::function<double(std::uint32_t)> by_mm;
};
void PrintTo(const BentEnd& end, std::ostream* out) {
  *out << end.name;
}

class BentEnds : public testing::TestWithParam<BentEnd> {};

// The tube stays a tube, so the cap is its circle, whatever the rim was.
TEST_P(BentEnds, AreCutBackToTheSectionOfTheTube) {
  const ClosedSurfaceMade made = closed(with_end_moved(open_tube({}), 48, GetParam().by_mm));
  ASSERT_EQ(openings_of(made), 2U);
  const ClosedRim& end = upper(made);
  const double circle = 0.5 * 48 * 9 * std::sin(2 * kPi / 48);
  EXPECT_NEAR(end.area_mm2 * std::abs(end.normal.z()), circle, 0.01 * circle);
  EXPECT_LE(end.cut_off_mm, GetParam().max_cut_off_mm);
  EXPECT_GT(end.smallest_angle_deg, 10);
}

double saddle(double share, std::uint32_t i) {
  return share * 3 * std::cos(2 * 2 * kPi * i / 48);
}

INSTANTIATE_TEST_SUITE_P(
    Closing, BentEnds,
    testing::Values(BentEnd{"saw_tooth", 0.45, [](std::uint32_t i) { return i % 2 == 0 ? 0.4 : 0.0; }},
                    BentEnd{"steps", 0.45, [](std::uint32_t i) { return i / 3 % 2 == 0 ? 0.35 : 0.0; }},
                    BentEnd{"saddle_10_percent", 0.7, [](std::uint32_t i) { return saddle(0.1, i); }},
                    BentEnd{"saddle_30_percent", 1.9, [](std::uint32_t i) { return saddle(0.3, i); }},
                    BentEnd{"spike", 1.5, [](std::uint32_t i) { return i == 5 ? 1.4 : 0.0; }},
                    BentEnd{"notch", 1.5, [](std::uint32_t i) { return i == 5 ? -0.35 : 0.0; }},
                    BentEnd{"rough", 0.5, [](std::uint32_t i) { return 0.4 * std::fmod(0.618 * i, 1.0); }}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(Closing, AFlangeIsCutOffToTheTubeThatEndsInIt) {
  std::vector<Vec2> profile;
  for (int i = 0; i <= 30; ++i) profile.emplace_back(3, 0.4 * i);
  for (int i = 1; i <= 6; ++i) profile.emplace_back(3 + 0.4 * i, 12);
  const ClosedSurfaceMade made = closed(revolved(profile, 48));
  ASSERT_EQ(openings_of(made), 2U);
  const double circle = 0.5 * 48 * 9 * std::sin(2 * kPi / 48);
  EXPECT_NEAR(upper(made).area_mm2, circle, 0.01 * circle);
}

TEST(Closing, AFunnelIsCappedAtItsWideEnd) {
  std::vector<Vec2> profile;
  for (int i = 0; i <= 30; ++i) profile.emplace_back(3 + 0.004 * i * i, 0.4 * i);
  const ClosedSurfaceMade made = closed(revolved(profile, 60));
  ASSERT_EQ(openings_of(made), 2U);
  EXPECT_NEAR(upper(made).area_mm2, 0.5 * 60 * 6.6 * 6.6 * std::sin(2 * kPi / 60), 1e-6);
}

TEST(Closing, AConeHasOneOpening) {
  std::vector<Vec2> profile;
  for (int i = 1; i <= 20; ++i) profile.emplace_back(0.25 * i, 0.5 * i);
  TriangleMesh cone = revolved(profile, 40);
  const auto apex = static_cast<std::uint32_t>(cone.points.size());
  cone.points.emplace_back(0, 0, 0);
  for (std::uint32_t i = 0; i < 40; ++i) {
    cone.triangles.push_back({(i + 1) % 40, i, apex});
    cone.patches.push_back(0);
  }
  const ClosedSurfaceMade made = closed(cone);
  EXPECT_EQ(made.rims.size(), 1U);
  EXPECT_EQ(openings_of(made), 1U);
}

TEST(Closing, PinholesBecomeWall) {
  TriangleMesh tube = open_tube({});
  const double whole = volume_of(closed(tube).surface);
  std::vector<Cell<3>> kept;
  // One triangle, two neighbours, and a fan around a point.
  for (std::size_t t = 0; t < tube.triangles.size(); ++t) {
    const Cell<3>& c = tube.triangles[t];
    const bool is_of_fan = std::find(c.begin(), c.end(), 48 * 30 + 10U) != c.end();
    if (t != 500 && t != 800 && t != 801 && !is_of_fan) kept.push_back(c);
  }
  tube.triangles = kept;
  tube.patches.assign(kept.size(), 0);
  const ClosedSurfaceMade made = closed(tube);
  EXPECT_EQ(openings_of(made), 2U);
  ASSERT_EQ(made.rims.size(), 5U);
  for (const ClosedRim& rim : made.rims) EXPECT_TRUE(rim.is_opening || rim.patch == 0);
  EXPECT_NEAR(volume_of(made.surface), whole, 1e-3 * whole);
}

/// A hole that the cut comes to, or that goes with what is cut off, took the opening away: both became wall.
TEST(Closing, APinholeBesideABentEndLeavesTheOpening) {
  const TriangleMesh bent = with_end_moved(open_tube({}), 48, [](std::uint32_t i) { return saddle(0.3, i); });
  double top = 0;
  for (const Vec3& p : bent.points) top = std::max(top, p.z());
  const double circle = 0.5 * 48 * 9 * std::sin(2 * kPi / 48);
  int count = 0;
  for (std::size_t t = 0; t < bent.triangles.size(); t += 7) {
    const Cell<3>& c = bent.triangles[t];
    const auto is_within = [&](auto v) {
      return v + 48 < bent.points.size() && bent.points[v].z() > top - 3;
    };
    if (!std::all_of(c.begin(), c.end(), is_within)) continue;
    TriangleMesh tube = bent;
    tube.triangles.erase(tube.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    tube.patches.pop_back();
    const ClosedSurfaceMade made = closed(tube);
    ASSERT_EQ(openings_of(made), 2U) << t;
    const ClosedRim& end = upper(made);
    EXPECT_NEAR(end.area_mm2 * std::abs(end.normal.z()), circle, 0.01 * circle) << t;
    ++count;
  }
  EXPECT_GT(count, 10);
}

/// Triangles that share no corners were left out, and the surface had none then.
TEST(Closing, TrianglesWithoutNeighboursAreRefused) {
  const TriangleMesh tube = open_tube({});
  TriangleMesh torn;
  for (std::size_t t = 0; t < tube.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(torn.points.size());
    for (const std::uint32_t v : tube.triangles[t])
      torn.points.emplace_back(tube.points[v] + 0.01 * std::sin(double(t)) * Vec3(1, 0.5, 0.2));
    torn.triangles.push_back({first, first + 1, first + 2});
  }
  torn.patches.assign(torn.triangles.size(), 0);
  try {
    static_cast<void>(close_surface(torn.points, torn.triangles, torn.patches, 1));
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("join points within"), std::string::npos) << error.what();
  }
}

/// Planes that cut the notches of a rim off pass through holes below, and no closed curve was left: wall.
TEST(Closing, ARimWithTrianglesMissingAboveHolesIsAnOpening) {
  TriangleMesh tube = open_tube({});
  const double circle = 0.5 * 48 * 9 * std::sin(2 * kPi / 48);
  double top = 0;
  for (const Vec3& p : tube.points) top = std::max(top, p.z());
  std::size_t at_rim = 0, below = 0;
  const auto is_missing = [&](const Cell<3>& c) {
    const double highest = std::max({tube.points[c[0]].z(), tube.points[c[1]].z(), tube.points[c[2]].z()});
    const auto on_rim = std::count_if(c.begin(), c.end(), [&](auto v) { return tube.points[v].z() == top; });
    if (on_rim == 2) return ++at_rim % 16 == 0;
    return on_rim == 0 && highest > top - 1.5 && ++below % 11 == 0;
  };
  std::erase_if(tube.triangles, is_missing);
  tube.patches.resize(tube.triangles.size());
  const ClosedSurfaceMade made = closed(tube);
  ASSERT_EQ(openings_of(made), 2U);
  EXPECT_NEAR(upper(made).area_mm2, circle, 0.01 * circle);
}

/// A cube of n squares along each edge without some of its squares.
TriangleMesh cube_without(int n, const std::function<bool(const Vec3& middle)>& is_cut_out) {
  TriangleMesh cube;
  const auto add_side = [&](const Vec3& corner, const Vec3& u, const Vec3& v) {
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        const Vec3 a = corner + i * u + k * v;
        if (is_cut_out(a + 0.5 * (u + v))) continue;
        const auto first = static_cast<std::uint32_t>(cube.points.size());
        for (const Vec3& p : {a, Vec3(a + u), Vec3(a + u + v), Vec3(a + v)}) cube.points.push_back(p);
        cube.triangles.push_back({first, first + 1, first + 2});
        cube.triangles.push_back({first, first + 2, first + 3});
      }
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  add_side({0, 0, 0}, y, x), add_side(n * z, x, y), add_side({0, 0, 0}, x, z);
  add_side(n * y, z, x), add_side({0, 0, 0}, z, y), add_side(n * x, y, z);
  cube.patches.assign(cube.triangles.size(), 0);
  return cube;
}

TEST(Closing, OpeningsThatShareAVertexAreBothPlanar) {
  const int n = 16;
  // On two sides, with one point of the edge between them in common.
  const ClosedSurfaceMade made = closed(cube_without(n, [&](const Vec3& m) {
    const bool is_on_top = m.z() == n && m.x() < 6 && m.y() > 2 && m.y() < 8;
    const bool is_on_side = m.x() == 0 && m.z() > n - 6 && m.y() > 8 && m.y() < 14;
    return is_on_top || is_on_side;
  }));
  EXPECT_EQ(openings_of(made), 2U);
  EXPECT_NEAR(volume_of(made.surface), n * n * n, 1e-9);
  // In one plane.
  const ClosedSurfaceMade flat = closed(cube_without(n, [&](const Vec3& m) {
    const bool is_low = m.x() > 2 && m.x() < 8 && m.y() > 2 && m.y() < 8;
    const bool is_high = m.x() > 8 && m.x() < 14 && m.y() > 8 && m.y() < 14;
    return m.z() == n && (is_low || is_high);
  }));
  EXPECT_EQ(openings_of(flat), 2U);
  EXPECT_NEAR(volume_of(flat.surface), n * n * n, 1e-9);
}

TEST(Closing, AClosedSurfaceStaysAsItIs) {
  const TriangleSoup ball = icosphere(3, 5);
  const ClosedSurfaceMade made = close_surface(ball.points, ball.triangles, {}, 1);
  EXPECT_TRUE(made.rims.empty());
  EXPECT_EQ(made.surface.triangles.size(), ball.triangles.size());
}

/// The triangles of a ball whose middles are within an angle of +z go.
TriangleMesh ball_without_cap(int halvings, double angle) {
  const TriangleSoup ball = icosphere(halvings, 1);
  TriangleMesh open = weld(ball.points, ball.triangles, {});
  std::erase_if(open.triangles, [&](const Cell<3>& t) {
    const Vec3 middle = (open.points[t[0]] + open.points[t[1]] + open.points[t[2]]) / 3;
    return middle.normalized().z() > std::cos(angle);
  });
  open.patches.assign(open.triangles.size(), 0);
  return open;
}

// A filling that goes on as the wall bends is nearer to the ball than a flat one, whose depth is 1 -
// cos(angle).
TEST(FillHole, FollowsTheWallAround) {
  for (const double angle : {0.3, 0.6, 0.9}) {
    TriangleMesh open = ball_without_cap(4, angle);
    const std::size_t first = open.triangles.size();
    const std::vector<Rim> rims = find_rims(open);
    ASSERT_EQ(rims.size(), 1U);
    fill_hole(open, rims[0], 0);
    EXPECT_TRUE(find_rims(open).empty());
    EXPECT_TRUE(find_self_crossings(open.points, open.triangles).empty());
    double farthest = 0;
    for (std::size_t t = first; t < open.triangles.size(); ++t)
      for (const std::uint32_t v : open.triangles[t])
        farthest = std::max(farthest, std::abs(open.points[v].norm() - 1));
    const double depth = 1 - std::cos(angle), under_flat = kPi * depth * depth * (3 - depth) / 3;
    EXPECT_LT(farthest, 0.35 * depth) << angle;
    EXPECT_NEAR(volume_of(open), 4 * kPi / 3, 0.3 * under_flat + 0.02) << angle;
  }
}

/// Too coarse to be openings; but a wall runs up to each, which is told.
TEST(CloseSurface, CapsPlanarEndsOfFourToSevenEdges) {
  for (const std::uint32_t around : {4U, 5U, 6U, 7U}) {
    // Turned at random, so that ends are planar up to rounding.
    TriangleMesh tube = open_tube({.radius_mm = 2, .length_mm = 12, .around = around});
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& p : tube.points) p = turn * p + Vec3(101.3, -57.1, 12.9);
    const ClosedSurfaceMade made = closed(tube);
    ASSERT_EQ(made.rims.size(), 2u) << around;
    for (const ClosedRim& rim : made.rims) EXPECT_TRUE(rim.is_opening) << around;
  }
}

TEST(CloseSurface, SeesWallsThatRunUpToFourToSevenBentEdges) {
  for (const std::uint32_t around : {4U, 5U, 7U}) {
    TriangleMesh tube = open_tube({.radius_mm = 2, .length_mm = 12, .around = around});
    for (Vec3& p : tube.points)
      if (p.x() > 0.5) p.z() += 0.1;
    const ClosedSurfaceMade made = closed(tube);
    ASSERT_EQ(made.rims.size(), 2u) << around;
    for (const ClosedRim& rim : made.rims) EXPECT_TRUE(!rim.is_opening && rim.ends_wall) << around;
  }
}

/// Edges of a ragged rim are long, so that its radius is less than two of them.
TEST(CloseSurface, CutsTheRaggedEndOfACoarseVesselOff) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 14, .around = 11});
  double top = 0;
  for (const Vec3& p : tube.points) top = std::max(top, p.z());
  std::erase_if(tube.triangles, [&](const Cell<3>& t) {  // Every other triangle of the last row.
    return std::count_if(t.begin(), t.end(), [&](auto v) { return tube.points[v].z() > top - 1e-9; }) == 2;
  });
  tube.patches.resize(tube.triangles.size());
  const std::vector<Rim> rims = find_rims(tube);
  ASSERT_TRUE(std::any_of(rims.begin(), rims.end(), [](const Rim& rim) {
    return rim.vertices.size() == 22 && rim.radius_mm < 2 * rim.mean_edge_mm;
  }));
  const ClosedSurfaceMade made = closed(tube);
  ASSERT_EQ(made.rims.size(), 2u);
  for (const ClosedRim& rim : made.rims) EXPECT_TRUE(rim.is_opening);
}

/// Two skins of a wall, each open at both ends; the inner one moved aside.
TriangleMesh two_skins(double inner_radius_mm, const Vec3& aside, std::uint32_t around) {
  TriangleMesh skins = open_tube({.radius_mm = 3, .length_mm = 12, .around = 48});
  const TriangleMesh inner = open_tube({.radius_mm = inner_radius_mm, .length_mm = 12, .around = around});
  const auto first = static_cast<std::uint32_t>(skins.points.size());
  for (const Vec3& p : inner.points) skins.points.push_back(p + aside);
  for (const auto& [a, b, c] : inner.triangles) skins.triangles.push_back({a + first, b + first, c + first});
  skins.patches.resize(skins.triangles.size(), 0);
  return skins;
}

TEST(CloseSurface, ClosesTheEndsOfAWallByRings) {
  for (const double radius_mm : {1.0, 2.0, 2.7}) {
    const double step = 0.002;  // Not quite in the plane of the outer rims.
    const TriangleMesh skins = two_skins(radius_mm, Vec3(0.2, 0.05, step), radius_mm < 2 ? 20 : 40);
    const ClosedSurfaceMade made = closed(skins);
    ASSERT_EQ(made.rims.size(), 2u) << radius_mm;
    const double n = radius_mm < 2 ? 20 : 40;
    const auto polygon = [](double radius, double corners) {
      return 0.5 * corners * radius * radius * std::sin(2 * kPi / corners);
    };
    const double ring_mm2 = polygon(3, 48) - polygon(radius_mm, n);
    for (const ClosedRim& rim : made.rims) {
      EXPECT_TRUE(rim.is_opening);
      EXPECT_NEAR(rim.area_mm2, ring_mm2, 1e-9 * ring_mm2);
      EXPECT_GT(rim.smallest_angle_deg, 15) << radius_mm;
    }
    EXPECT_NEAR(volume_of(made.surface), 12 * ring_mm2, 1e-3 * 12 * ring_mm2) << radius_mm;
  }
}

/// Skins that end raggedly, or one up to a radius before the other, are cut by one plane.
TEST(CloseSurface, OnePlaneCutsSkinsThatDoNotEndInOne) {
  for (const double step : {0.0, 0.5, 1.5})
    for (const double ragged : {0.0, 0.3}) {
      TriangleMesh skins = two_skins(2, Vec3(0.2, 0.05, step), 40);
      std::mt19937 random(7);
      std::uniform_real_distribution<double> unit(0, 1);
      for (Vec3& p : skins.points)
        if (std::min(std::abs(p.z()), std::abs(p.z() - step)) < 1e-9) p.z() += ragged * unit(random);
      const ClosedSurfaceMade made = closed(skins);
      ASSERT_EQ(made.rims.size(), 2u) << step << ", " << ragged;
      for (const ClosedRim& rim : made.rims) {
        EXPECT_TRUE(rim.is_opening && rim.is_ring) << step << ", " << ragged;
        const double ring_mm2 = kPi * (3 * 3 - 2 * 2);
        EXPECT_NEAR(rim.area_mm2, ring_mm2, 0.02 * ring_mm2) << step << ", " << ragged;
      }
    }
}

TEST(CloseSurface, AVesselBesideAnotherIsNoInnerSkin) {
  const ClosedSurfaceMade made = closed(two_skins(2, Vec3(6, 0, 0), 40));
  EXPECT_EQ(made.rims.size(), 4u);
}

TEST(FillHole, OfManyEdgesIsDivided) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 0.2, .around = 260});
  for (const Rim& rim : find_rims(tube)) fill_hole(tube, rim, 0);
  EXPECT_TRUE(find_rims(tube).empty());
  EXPECT_NEAR(volume_of(tube), 0.2 * kPi * 9, 0.1);
}

/// Cuts a surface by a plane: exactly along it, or by leaving out the triangles that reach beyond it.
TriangleMesh cut_by_plane(const TriangleSoup& given, const Vec3& normal, double offset, bool is_ragged) {
  TriangleMesh cut;
  cut.points = given.points;
  const auto height = [&](std::uint32_t v) { return normal.dot(cut.points[v]) - offset; };
  const auto crossing = [&](std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax(a, b);
    const double share = height(low) / (height(low) - height(high));
    const Vec3 place = cut.points[low] + share * (cut.points[high] - cut.points[low]);
    cut.points.push_back(place);
    return static_cast<std::uint32_t>(cut.points.size() - 1);
  };
  for (const Cell<3>& t : given.triangles) {
    const auto above = std::count_if(t.begin(), t.end(), [&](std::uint32_t v) { return height(v) > 0; });
    if (above == 0) cut.triangles.push_back(t);
    if (above == 0 || above == 3 || is_ragged) continue;
    std::vector<std::uint32_t> left;
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t a = t[s], b = t[(s + 1) % 3];
      if (height(a) <= 0) left.push_back(a);
      if ((height(a) > 0) != (height(b) > 0)) left.push_back(crossing(a, b));
    }
    for (std::size_t i = 2; i < left.size(); ++i) cut.triangles.push_back({left[0], left[i - 1], left[i]});
  }
  return weld(cut.points, cut.triangles, {});
}

class RandomCuts : public testing::TestWithParam<bool> {};

TEST_P(RandomCuts, OfBallsAndRingsAreCapped) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> share(-0.7, 0.7);
  const TriangleSoup ball = icosphere(4, 5), ring = torus_surface(8, 2.5, 96, 30);
  for (int trial = 0; trial < 12; ++trial) {
    const TriangleSoup& given = trial % 2 == 0 ? ball : ring;
    Vec3 normal = Vec3(gauss(random), gauss(random), gauss(random)).normalized();
    // Rings are not cut into bowls, nor along their wall: teeth that lie on a cap may be refused as crossing.
    if (std::abs(normal.z()) > (GetParam() ? 0.75 : 0.9)) std::swap(normal.x(), normal.z());
    const double reach = trial % 2 == 0 ? 5 : 2.5 + 8 * std::hypot(normal.x(), normal.y());
    const double offset = share(random) * reach;
    SCOPED_TRACE(trial);
    const TriangleMesh open = cut_by_plane(given, normal, offset, GetParam());
    const ClosedSurfaceMade made = closed(open);
    double area = 0;
    for (const ClosedRim& rim : made.rims)
      area += rim.is_opening && rim.normal.dot(normal) > 0.9 ? rim.area_mm2 : 0;
    if (trial % 2 == 0) {
      const double circle = kPi * (25 - offset * offset);
      EXPECT_NEAR(area, circle, (GetParam() ? 0.15 : 0.01) * kPi * 25);
    }
    EXPECT_TRUE(GetParam() || area > 0) << normal.transpose() << " at " << offset;
  }
}

INSTANTIATE_TEST_SUITE_P(Closing, RandomCuts, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "Ragged" : "Exact"; });

}  // namespace
}  // namespace lumesh::surfaces
