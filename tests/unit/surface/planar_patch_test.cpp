#include "lumesh/surface/planar_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh::surfaces {
namespace {

std::vector<Vec2> round_polygon(int corners, const std::function<double(double)>& radius) {
  std::vector<Vec2> polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    polygon.push_back(radius(angle) * Vec2(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

double polygon_area(const std::vector<Vec2>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

Vec3 lifted(const Vec2& p) {
  return {p.x(), p.y(), 0};
}

double smallest_angle_deg(const PlanarPatch& patch) {
  double smallest = 180;
  for (const auto& [a, b, c] : patch.triangles) {
    const double cosine =
        cosine_of_smallest_angle(lifted(patch.points[a]), lifted(patch.points[b]), lifted(patch.points[c]));
    smallest = std::min(smallest, std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
  }
  return smallest;
}

/// Positive triangles that fill the polygon once, with its edges and no other open ones.
void expect_fills(const PlanarPatch& patch, const std::vector<Vec2>& polygon) {
  double area = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Cell<3>& t : patch.triangles) {
    ASSERT_GT(orient2d(patch.points[t[0]], patch.points[t[1]], patch.points[t[2]]), 0);
    const Vec2 u = patch.points[t[1]] - patch.points[t[0]], v = patch.points[t[2]] - patch.points[t[0]];
    area += (u.x() * v.y() - u.y() * v.x()) / 2;
    for (std::size_t s = 0; s < 3; ++s) ++edges[std::minmax(t[s], t[(s + 1) % 3])];
  }
  EXPECT_NEAR(area, polygon_area(polygon), 1e-12 * area);
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    EXPECT_LE(count, 2);
    if (count > 1) continue;
    ++open;
    EXPECT_TRUE(edge.second == edge.first + 1 || (edge.first == 0 && edge.second == polygon.size() - 1));
  }
  EXPECT_EQ(open, polygon.size());
}

TEST(PlanarPatch, OfARoundRimHasGoodAnglesAndEdgesLikeIt) {
  for (const int corners : {6, 7, 12, 33, 100, 250}) {
    const auto polygon = round_polygon(corners, [](double) { return 5.0; });
    const auto patch = fill_polygon(polygon);
    ASSERT_TRUE(patch) << corners;
    expect_fills(*patch, polygon);
    EXPECT_GT(smallest_angle_deg(*patch), 28) << corners;
    const double edge = (polygon[1] - polygon[0]).norm();
    const double per_triangle = polygon_area(polygon) / static_cast<double>(patch->triangles.size());
    EXPECT_LT(per_triangle, 0.8 * edge * edge) << corners;  // 0.43 for equilateral ones.
    EXPECT_GT(per_triangle, 0.3 * edge * edge) << corners;
  }
}

TEST(PlanarPatch, OfRandomStarsFillsThemOnce) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> factor(0.4, 1.6);
  for (int trial = 0; trial < 60; ++trial) {
    const auto polygon =
        round_polygon(static_cast<int>(3 + random() % 90), [&](double) { return factor(random); });
    const auto patch = fill_polygon(polygon);
    ASSERT_TRUE(patch);
    expect_fills(*patch, polygon);
  }
}

TEST(PlanarPatch, OfAPolygonWithCornersOnItsSidesHasNoFlatTriangle) {
  std::vector<Vec2> polygon;
  for (int i = 0; i < 8; ++i) polygon.emplace_back(i, 0);
  for (int i = 0; i < 4; ++i) polygon.emplace_back(8, i);
  for (int i = 0; i < 8; ++i) polygon.emplace_back(8 - i, 4);
  for (int i = 0; i < 4; ++i) polygon.emplace_back(0, 4 - i);
  const auto patch = fill_polygon(polygon);
  ASSERT_TRUE(patch);
  expect_fills(*patch, polygon);
  EXPECT_GT(smallest_angle_deg(*patch), 25);
}

TEST(PlanarPatch, OfPolygonsThatCrossOrTouchThemselvesIsNone) {
  EXPECT_FALSE(fill_polygon(std::vector<Vec2>{{0, 0}, {2, 2}, {2, 0}, {0, 2}}));
  EXPECT_FALSE(fill_polygon(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}));
  EXPECT_FALSE(fill_polygon(std::vector<Vec2>{{0, 0}, {4, 0}, {6, 0}, {4, 0}, {4, 4}}));
  EXPECT_FALSE(fill_polygon(std::vector<Vec2>{{0, 0}, {0, 4}, {4, 4}, {4, 0}}));  // Clockwise.
}

/// A star of random radii that runs clockwise.
std::vector<Vec2> star_hole(const Vec2& centre, double radius, int corners, std::mt19937& random) {
  std::uniform_real_distribution<double> factor(0.6, 1);
  std::vector<Vec2> hole = round_polygon(corners, [&](double) { return factor(random) * radius; });
  for (Vec2& p : hole) p += centre;
  std::reverse(hole.begin(), hole.end());
  return hole;
}

TEST(PlanarPatch, LeavesHolesOut) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int trial = 0; trial < 40; ++trial) {
    const auto polygon = round_polygon(20 + static_cast<int>(random() % 40), [](double) { return 10.0; });
    std::vector<std::vector<Vec2>> holes;
    const std::array<Vec2, 4> centres = {Vec2(-4.6, 0), Vec2(4.6, 0.1), Vec2(0, 4.7), Vec2(0.2, -4.7)};
    const std::size_t count = trial % 4 + 1;
    for (std::size_t h = 0; h < count; ++h)
      holes.push_back(star_hole(centres[h], 3.2, 3 + static_cast<int>(random() % 30), random));
    const auto patch = fill_polygon(polygon, holes);
    ASSERT_TRUE(patch);
    double area = polygon_area(polygon), made = 0;
    std::size_t corners = polygon.size();
    for (const auto& hole : holes) {
      area += polygon_area(hole);  // Negative.
      corners += hole.size();
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Cell<3>& t : patch->triangles) {
      EXPECT_GT(orient2d(patch->points[t[0]], patch->points[t[1]], patch->points[t[2]]), 0);
      const Vec2 u = patch->points[t[1]] - patch->points[t[0]], v = patch->points[t[2]] - patch->points[t[0]];
      made += (u.x() * v.y() - u.y() * v.x()) / 2;
      for (std::size_t s = 0; s < 3; ++s) ++edges[std::minmax(t[s], t[(s + 1) % 3])];
    }
    EXPECT_NEAR(made, area, 1e-12 * area);
    const auto open = std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second == 1; });
    EXPECT_EQ(static_cast<std::size_t>(open), corners);
    EXPECT_TRUE(std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second <= 2; }));
  }
}

TEST(PlanarPatch, OfARingOfTwoRoundRimsHasGoodAngles) {
  for (const double inner : {2.0, 3.5, 4.5}) {
    const auto polygon = round_polygon(64, [](double) { return 5.0; });
    auto hole = round_polygon(static_cast<int>(64 * inner / 5), [&](double) { return inner; });
    std::reverse(hole.begin(), hole.end());
    const auto patch = fill_polygon(polygon, std::vector<std::vector<Vec2>>{hole});
    ASSERT_TRUE(patch);
    EXPECT_GT(smallest_angle_deg(*patch), 25) << inner;
  }
}

TEST(PlanarPatch, OfHolesThatAreNoneIsNone) {
  const auto polygon = round_polygon(30, [](double) { return 5.0; });
  std::mt19937 random(1);
  const auto none = [&](const std::vector<std::vector<Vec2>>& holes) {
    return !fill_polygon(polygon, holes);
  };
  std::vector<Vec2> turned = star_hole(Vec2::Zero(), 2, 9, random);
  std::reverse(turned.begin(), turned.end());
  EXPECT_TRUE(none({turned}));
  EXPECT_TRUE(none({star_hole(Vec2(4, 0), 3, 9, random)}));   // Across the rim.
  EXPECT_TRUE(none({star_hole(Vec2(20, 0), 3, 9, random)}));  // Outside.
  EXPECT_TRUE(none({star_hole(Vec2(0, 0), 3, 9, random), star_hole(Vec2(0, 0), 1, 9, random)}));
}

}  // namespace
}  // namespace lumesh::surfaces
