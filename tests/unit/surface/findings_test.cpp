// Findings of surfaces with faults put in on purpose: how many, and where.
#include "lumesh/surface/findings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "fixtures/surfaces.hpp"
#include "lumesh/surface/edges.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

using fixtures::icosphere;
using fixtures::TriangleSoup;
using fixtures::unit_cube_surface;

/// "kind:count kind:count", faults first by "!".
std::string words_of(const std::vector<Finding>& findings) {
  std::string words;
  for (const Finding& finding : findings)
    words += (words.empty() ? "" : " ") + std::string(finding.severity == Severity::kFault ? "!" : "") +
             finding.kind + ":" + std::to_string(finding.count);
  return words;
}
std::string words_of(const TriangleSoup& soup) {
  return words_of(findings_of(soup.points, soup.triangles));
}
TriangleSoup ball_at(const Vec3& centre, double radius, int halvings = 2) {
  return icosphere(halvings, radius).moved([&](const Vec3& p) { return Vec3(p + centre); });
}

TEST(Findings, OfASoundSurfaceAreNone) {
  EXPECT_EQ(words_of(icosphere(2)), "");
  EXPECT_EQ(words_of(unit_cube_surface()), "");
}

TEST(Findings, OpeningsEndAWallHolesAreWithinIt) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 48});
  EXPECT_EQ(words_of(findings_of(tube.points, tube.triangles)), "openings:2");
  // A flat, wide piece of a wall is missing: still a hole, but for one that nobody can fill.
  const auto sheet_without = [](double radius) {
    TriangleMesh sheet = square_sheet(80);
    std::erase_if(sheet.triangles, [&](const Cell<3>& t) {
      const Vec3 middle = (sheet.points[t[0]] + sheet.points[t[1]] + sheet.points[t[2]]) / 3;
      return (middle - Vec3(40, 40, 0)).norm() < radius;
    });
    return sheet;
  };
  const TriangleMesh torn = sheet_without(3), window = sheet_without(8);
  const std::vector<Finding> findings = findings_of(torn.points, torn.triangles);
  ASSERT_EQ(words_of(findings), "!holes:1 openings:1");
  EXPECT_LT((findings[0].places_mm[0] - Vec3(40, 40, 0)).norm(), 0.5);
  EXPECT_EQ(words_of(findings_of(window.points, window.triangles)), "openings:2");
}

TEST(Findings, AVertexAbsurdlyFarAwayIsAFault) {
  for (const double place : {1e5, 1e19, -1e38, 1e300}) {
    TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 48});
    tube.points[200].y() = place;
    const std::vector<Finding> findings = findings_of(tube.points, tube.triangles);
    ASSERT_FALSE(findings.empty());
    const auto far = std::ranges::find(findings, "far_vertices", &Finding::kind);
    ASSERT_NE(far, findings.end()) << place;
    EXPECT_EQ(far->severity, Severity::kFault);
    EXPECT_EQ(far->count, 1U);
    EXPECT_EQ(far->places_mm[0].y(), place);
  }
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 48});
  tube.points[200].y() = 1e3;  // A needle, but not absurd.
  const std::vector<Finding> findings = findings_of(tube.points, tube.triangles);
  EXPECT_EQ(std::ranges::count(findings, "far_vertices", &Finding::kind), 0);
  // A small finely triangulated part within a large coarse one.
  TriangleSoup ball = icosphere(5, 0.01);
  const TriangleSoup box = icosphere(0, 100);
  const auto first = static_cast<std::uint32_t>(ball.points.size());
  ball.points.insert(ball.points.end(), box.points.begin(), box.points.end());
  for (const Cell<3>& t : box.triangles) ball.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  EXPECT_EQ(words_of(ball).find("far_vertices"), std::string::npos);
}

/// Triangles with corners of their own, each moved along every axis by up to a distance.
TriangleMesh shaken(const TriangleMesh& mesh, double distance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1, 1);
  TriangleMesh own;
  for (const Cell<3>& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(own.points.size());
    for (const std::uint32_t v : t)
      own.points.push_back(mesh.points[v] + distance * Vec3(share(random), share(random), share(random)));
    own.triangles.push_back({first, first + 1, first + 2});
  }
  return own;
}

TEST(Findings, CornersTooFarApartToBeJoinedAreNamedWithTheirDistance) {
  const TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 24});
  TriangleMesh near = shaken(tube, 5e-4), far = shaken(tube, 1e-2);  // The diagonal is 22 mm long.
  EXPECT_GT(join_torn_corners(near.points, near.triangles), 0);
  const std::string words = words_of(findings_of(near.points, near.triangles));
  EXPECT_EQ(words.substr(words.find(' ') + 1), "openings:2");
  EXPECT_EQ(join_torn_corners(far.points, far.triangles), 0);
  const std::vector<Finding> findings = findings_of(far.points, far.triangles);
  const auto torn = std::ranges::find(findings, "torn_corners", &Finding::kind);
  ASSERT_NE(torn, findings.end());
  EXPECT_EQ(torn->severity, Severity::kFault);
  EXPECT_GT(torn->count, tube.triangles.size() / 2);
  EXPECT_NE(torn->remedy.find("join points within 0.0"), std::string::npos) << torn->remedy;
}

TEST(Findings, AFinMakesAnEdgeOfThreeTriangles) {
  TriangleSoup ball = icosphere(2);
  const Cell<3> at = ball.triangles[17];
  ball.points.push_back(1.2 * ball.points[at[0]]);
  ball.triangles.push_back({at[0], at[1], static_cast<std::uint32_t>(ball.points.size() - 1)});
  const std::vector<Finding> findings = findings_of(ball.points, ball.triangles);
  const auto crowded = std::find_if(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.kind == "non_manifold_edges";
  });
  ASSERT_NE(crowded, findings.end());
  EXPECT_EQ(crowded->count, 1U);
  EXPECT_LT((crowded->places_mm[0] - 0.5 * (ball.points[at[0]] + ball.points[at[1]])).norm(), 1e-12);
}

TEST(Findings, TwoConesThatShareATipTouchInOnePoint) {
  TriangleSoup pair = unit_cube_surface();
  pair.append(unit_cube_surface().moved([](const Vec3& p) { return Vec3(p + Vec3::Ones()); }));
  const std::vector<Finding> findings = findings_of(pair.points, pair.triangles);
  EXPECT_EQ(words_of(findings), "!non_manifold_vertices:1 duplicate_points:1 components:2");
  ASSERT_FALSE(findings[0].places_mm.empty());
  EXPECT_EQ(findings[0].places_mm[0], Vec3(1, 1, 1));
}

TEST(Findings, TurnedTrianglesAreCounted) {
  TriangleSoup ball = icosphere(2);
  for (const std::size_t t : {3U, 50U, 51U, 200U}) std::swap(ball.triangles[t][0], ball.triangles[t][1]);
  EXPECT_EQ(words_of(ball), "turned_triangles:4");
  EXPECT_EQ(words_of(icosphere(2).reversed()), "inside_out:1");
}

TEST(Findings, BallsThatCrossDoSoOnACircle) {
  TriangleSoup pair = ball_at({0, 0, 0}, 1);
  pair.append(ball_at({1.2, 0.01, 0.02}, 1));
  const std::vector<Finding> findings = findings_of(pair.points, pair.triangles);
  EXPECT_EQ(findings[0].kind, "self_intersections");
  EXPECT_EQ(findings[0].severity, Severity::kFault);
  for (const Vec3& p : findings[0].places_mm) {
    EXPECT_NEAR(p.norm(), 1, 0.2);
    EXPECT_NEAR((p - Vec3(1.2, 0.01, 0.02)).norm(), 1, 0.2);
  }
}

TEST(Findings, WhatIsThereTwiceIsCounted) {
  TriangleSoup ball = icosphere(1);
  ball.append(icosphere(1));
  EXPECT_EQ(words_of(ball), "!duplicate_triangles:80 duplicate_points:42");
}

TEST(Findings, ShellsWithinOthersAndSpecksAreToldApart) {
  TriangleSoup nested = ball_at({0, 0, 0}, 1);
  nested.append(ball_at({0.1, 0, 0}, 0.5).reversed());
  nested.append(ball_at({3, 0, 0}, 0.01, 0));
  EXPECT_EQ(words_of(nested), "components:3 specks:1 nested_shells:1");
}

TEST(Findings, FlatAndThinTrianglesAreCounted) {
  TriangleSoup cube = unit_cube_surface();
  // A corner in the middle of an edge of one triangle, and one almost there.
  const auto divide = [&](const Vec3& middle) {
    const auto v = static_cast<std::uint32_t>(cube.points.size());
    cube.points.push_back(middle);
    const Cell<3> t = cube.triangles.back();
    cube.triangles.back() = {t[0], t[1], v};
    cube.triangles.push_back({t[1], t[2], v});
    cube.triangles.push_back({t[2], t[0], v});
  };
  divide((cube.points[cube.triangles.back()[2]] + cube.points[cube.triangles.back()[0]]) / 2);
  EXPECT_EQ(words_of(cube), "degenerate_triangles:1 local_intersections:2")
      << "its corner touches the triangle behind";
  TriangleSoup ball = icosphere(2);
  ball.points[5] *= 1000;  // Triangles as long as needles.
  const std::vector<Finding> findings = findings_of(ball.points, ball.triangles);
  ASSERT_EQ(words_of(findings).substr(0, 8), "needles:");
}

TEST(Findings, OfAMoebiusStripIsItsOneSide) {
  TriangleMesh strip;
  constexpr std::uint32_t kSteps = 24;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps;
    const Vec3 outwards(std::cos(angle), std::sin(angle), 0);
    const Vec3 across = 0.3 * (std::cos(angle / 2) * outwards + std::sin(angle / 2) * Vec3::UnitZ());
    strip.points.push_back(outwards + across);
    strip.points.push_back(outwards - across);
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const bool is_last = i + 1 == kSteps;  // The strip closes turned over.
    const std::uint32_t a = 2 * i, b = a + 1, c = is_last ? 1 : a + 2, d = is_last ? 0 : a + 3;
    strip.triangles.push_back({a, b, c});
    strip.triangles.push_back({b, d, c});
  }
  const std::string words = words_of(findings_of(strip.points, strip.triangles));
  EXPECT_NE(words.find("!one_sided:1"), std::string::npos) << words;
}

}  // namespace
}  // namespace lumesh::surfaces
