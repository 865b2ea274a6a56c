#include "lumesh/surface/rims.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "lumesh/surface/edges.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

TEST(Rims, OfATubeAreItsTwoCirclesPointingOut) {
  const TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 48});
  const std::vector<Rim> rims = find_rims(tube);
  ASSERT_EQ(rims.size(), 2U);
  for (const Rim& rim : rims) {
    EXPECT_EQ(rim.vertices.size(), 48U);
    // A polygon of 48 corners on the circle.
    const double polygon = 0.5 * 48 * 9 * std::sin(2 * std::numbers::pi / 48);
    EXPECT_NEAR(rim.area_mm2, polygon, 1e-9);
    EXPECT_NEAR(rim.deviation_mm, 0, 1e-12);
    EXPECT_TRUE(rim.is_flat() && rim.is_wide());
    EXPECT_NEAR(rim.normal.z(), rim.centre_mm.z() > 10 ? 1 : -1, 1e-12);
  }
}

TEST(Rims, TurnedTrianglesAreTurnedAlikeAndOutwards) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 24});
  std::mt19937 random(7);
  for (Cell<3>& t : tube.triangles)
    if (random() % 2 == 0) std::swap(t[0], t[1]);
  turn_alike(tube);
  std::vector<Rim> rims = find_rims(tube);
  ASSERT_EQ(rims.size(), 2U);
  turn_outwards(tube, rims);
  for (const Rim& rim : rims) EXPECT_NEAR(rim.normal.z(), rim.centre_mm.z() > 10 ? 1 : -1, 1e-12);
  for (const Rim& rim : find_rims(tube)) EXPECT_NEAR(rim.normal.z(), rim.centre_mm.z() > 10 ? 1 : -1, 1e-12);
}

TEST(Rims, ThatTouchInAPointAreTwo) {
  // A sheet of squares without two that share a corner.
  TriangleMesh sheet = square_sheet(6);
  const auto is_cut_out = [&](const Cell<3>& t) {
    const Vec3 middle = (sheet.points[t[0]] + sheet.points[t[1]] + sheet.points[t[2]]) / 3;
    const auto column = static_cast<int>(middle.x()), row = static_cast<int>(middle.y());
    return (column == 2 && row == 2) || (column == 3 && row == 3);
  };
  std::erase_if(sheet.triangles, is_cut_out);
  std::vector<std::size_t> lengths;
  for (const Rim& rim : find_rims(sheet)) lengths.push_back(rim.vertices.size());
  std::sort(lengths.begin(), lengths.end());
  EXPECT_EQ(lengths, (std::vector<std::size_t>{4, 4, 24}));
}

TEST(Rims, OfClosedSurfacesAreNone) {
  TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 24});
  for (const Rim& rim : find_rims(tube)) {
    const auto apex = static_cast<std::uint32_t>(tube.points.size());
    tube.points.push_back(rim.centre_mm);
    for (std::size_t i = 0; i < rim.vertices.size(); ++i)
      tube.triangles.push_back({rim.vertices[(i + 1) % rim.vertices.size()], rim.vertices[i], apex});
  }
  EXPECT_TRUE(find_rims(tube).empty());
}

TEST(Rims, EqualPointsAreOne) {
  const TriangleMesh tube = open_tube({.radius_mm = 3, .length_mm = 20, .around = 24});
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  for (const Cell<3>& t : tube.triangles) {
    Cell<3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = static_cast<std::uint32_t>(points.size());
      points.push_back(tube.points[t[i]]);
    }
    triangles.push_back(corners);
  }
  const TriangleMesh welded = weld(points, triangles, {});
  EXPECT_EQ(welded.points.size(), tube.points.size());
  EXPECT_EQ(find_rims(welded).size(), 2U);
}

}  // namespace
}  // namespace lumesh::surfaces
