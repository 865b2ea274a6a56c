#include "lumesh/surface/plane_cut.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/closing.hpp"
#include "lumesh/surface/edges.hpp"
#include "surface_shapes.hpp"

namespace lumesh::surfaces {
namespace {

using fixtures::icosphere;
using fixtures::torus_surface;
using fixtures::TriangleSoup;

TriangleMesh welded(const TriangleSoup& soup) {
  return weld(soup.points, soup.triangles, std::vector<std::int32_t>(soup.triangles.size(), 0));
}
/// Closed with caps 1 and 2.
TriangleMesh closed_tube(const TubeShape& shape = {}) {
  const TriangleMesh open = open_tube(shape);
  return close_surface(open.points, open.triangles, open.patches, 1).surface;
}
/// Bent by a quarter of a circle of radius 20 around the y axis.
TriangleMesh bent_tube() {
  TriangleMesh tube = closed_tube({3, 31.4, 48});
  for (Vec3& p : tube.points) {
    const double angle = p.z() / 20, off = 20 + p.x();
    p = {off * std::cos(angle), p.y(), off * std::sin(angle)};
  }
  return tube;
}

double volume_within(const TriangleMesh& surface) {
  double six = 0;
  for (const auto& [a, b, c] : surface.triangles)
    six += surface.points[a].dot(surface.points[b].cross(surface.points[c]));
  return six / 6;
}
double area_of_patches(const TriangleMesh& surface, std::int32_t first) {
  double area = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (const auto& [a, b, c] = surface.triangles[t]; surface.patches[t] >= first)
      area += triangle_area(surface.points[a], surface.points[b], surface.points[c]);
  return area;
}

/// Closed, turned alike, without crossings; caps of patch `first` on in the plane and turned along it.
void expect_sound_cut(const TriangleMesh& surface, const SectionPlane& plane, std::int32_t first) {
  for (const auto& beside : edge_neighbours(surface.triangles))
    for (const std::uint32_t t : beside) ASSERT_LT(t, kCrowdedEdge);
  TriangleMesh turned = surface;
  turn_alike(turned);
  EXPECT_EQ(turned.triangles, surface.triangles);
  EXPECT_TRUE(find_self_crossings(surface.points, surface.triangles).empty());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    if (surface.patches[t] < first) continue;
    for (const std::uint32_t v : surface.triangles[t])
      EXPECT_LT(std::abs(plane.height_mm(surface.points[v])), 1e-11);
    EXPECT_GT(triangle_normal(surface.points[a], surface.points[b], surface.points[c]).dot(plane.normal),
              0.999);
  }
}

template <class Cut>
std::string refusal(const Cut& cut) {
  try {
    cut();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  ADD_FAILURE() << "not refused";
  return "";
}

TEST(PlaneCut, BothHalvesOfRandomCutsMakeTheWhole) {
  const std::vector<TriangleMesh> shapes = {closed_tube(), welded(icosphere(4, 5)), bent_tube(),
                                            welded(torus_surface(6, 2, 80, 30))};
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0.2, 0.8);
  for (int i = 0; i < 20; ++i) {
    const TriangleMesh& shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    // Between two points of the surface.
    std::uniform_int_distribution<std::size_t> vertex(0, shape.points.size() - 1);
    const double t = share(random);
    const SectionPlane plane{(1 - t) * shape.points[vertex(random)] + t * shape.points[vertex(random)],
                             Vec3(normal(random), normal(random), normal(random)).normalized()};
    TriangleMesh below = shape, above = shape;
    std::int32_t caps = 0;
    try {
      caps = cut_off_beyond(below, plane, 5);
    } catch (const Error& error) {
      ASSERT_NE(std::string(error.what()).find("within another"), std::string::npos) << error.what();
      continue;  // A torus flat along the plane has one section within another.
    }
    ASSERT_GE(caps, 1);
    expect_sound_cut(below, plane, 5);
    const SectionPlane turned{plane.point_mm, -plane.normal};
    EXPECT_EQ(cut_off_beyond(above, turned, 5), caps);
    expect_sound_cut(above, turned, 5);
    EXPECT_NEAR(volume_within(below) + volume_within(above), volume_within(shape),
                3e-3 * volume_within(shape));
    EXPECT_NEAR(area_of_patches(below, 5), area_of_patches(above, 5), 1e-9 * area_of_patches(above, 5));
  }
}

TEST(PlaneCut, ASectionHasTheAreaOfTheShape) {
  TriangleMesh tube = closed_tube({3, 20, 96});
  const SectionPlane oblique{{0, 0, 9}, Vec3(0.5, 0, 1).normalized()};
  ASSERT_EQ(cut_off_beyond(tube, oblique, 5), 1);
  EXPECT_NEAR(area_of_patches(tube, 5), std::numbers::pi * 9 / oblique.normal.z(),
              2e-3 * std::numbers::pi * 9);
  EXPECT_NEAR(volume_within(tube), std::numbers::pi * 9 * 9, 2e-3 * std::numbers::pi * 81);
  TriangleMesh ball = welded(icosphere(5, 5));
  ASSERT_EQ(cut_off_beyond(ball, {{0, 0, 3}, {0, 0, 1}}, 5), 1);
  EXPECT_NEAR(area_of_patches(ball, 5), std::numbers::pi * 16, 5e-3 * std::numbers::pi * 16);
}

TEST(PlaneCut, APlaneInAnEndLeavesIt) {
  TriangleMesh tube = closed_tube();
  const TriangleMesh before = tube;
  EXPECT_EQ(cut_off_beyond(tube, {{0, 0, 20}, {0, 0, 1}}, 5), 0);
  EXPECT_EQ(tube.triangles.size(), before.triangles.size());
  EXPECT_NE(refusal([&] {
              cut_off_beyond(tube, {{0, 0, 20}, {0, 0, -1}}, 5);
            }).find("nothing"),
            std::string::npos);
  EXPECT_EQ(tube.triangles.size(), before.triangles.size());
}

/// The radius of a circle that a plane at a height cuts from a ball.
double circle_mm2(double radius, double height) {
  return std::numbers::pi * (radius * radius - height * height);
}

TEST(PlaneCut, HollowWallsGetRings) {
  TriangleSoup shell = icosphere(4, 5);
  shell.append(icosphere(4, 3).reversed());
  const TriangleMesh hollow = welded(shell);
  const double whole = volume_within(hollow);
  for (const double height : {0.1, -1.3, 2.2}) {
    const Vec3 normal = Vec3(0.1, -0.2, 1).normalized();
    TriangleMesh below = hollow, above = hollow;
    const SectionPlane plane{height * normal, normal}, turned{height * normal, -normal};
    EXPECT_EQ(cut_off_beyond(below, plane, 5), 1) << height;
    EXPECT_EQ(cut_off_beyond(above, turned, 5), 1) << height;
    expect_sound_cut(below, plane, 5);
    expect_sound_cut(above, turned, 5);
    EXPECT_NEAR(volume_within(below) + volume_within(above), whole, 0.002 * whole) << height;
    const double ring_mm2 = circle_mm2(5, height) - circle_mm2(3, height);
    EXPECT_NEAR(area_of_patches(below, 5), ring_mm2, 0.01 * ring_mm2) << height;
  }
}

TEST(PlaneCut, OneVesselIsCutAndAnotherStays) {
  TriangleMesh two = closed_tube();
  const TriangleMesh other = closed_tube();
  const auto offset = static_cast<std::uint32_t>(two.points.size());
  for (const Vec3& p : other.points) two.points.emplace_back(p + Vec3(6.5, 0, 0));
  for (const auto& [a, b, c] : other.triangles) two.triangles.push_back({a + offset, b + offset, c + offset});
  two.patches.insert(two.patches.end(), other.patches.begin(), other.patches.end());
  const SectionPlane plane{{0.4, -0.3, 6}, Vec3(0.1, 0, 1).normalized()};
  const SurfaceCut made = cut_off_end(two, plane, 3, 3, 5, std::vector<std::int32_t>{1, 2});
  expect_sound_cut(two, {plane.point_mm, made.normal}, 5);
  EXPECT_LT(made.normal.z(), 0);  // The shorter part goes.
  EXPECT_NEAR(made.section_mm2, std::numbers::pi * 9 / plane.normal.z(), 0.01 * std::numbers::pi * 9);
  EXPECT_NEAR(volume_within(two), std::numbers::pi * 9 * (14 + 20), 0.01 * std::numbers::pi * 9 * 34);
  std::size_t kept = 0;
  for (const Vec3& p : other.points)
    kept += std::count(two.points.begin(), two.points.end(), Vec3(p + Vec3(6.5, 0, 0)));
  EXPECT_EQ(kept, other.points.size());
}

TEST(PlaneCut, CutsThatLeaveOnePieceOrDivideAnEndAreRefused) {
  TriangleMesh ring = welded(torus_surface(6, 2, 80, 30));
  EXPECT_NE(refusal([&] {
              cut_off_end(ring, {{6, 0, 0}, {0, 1, 0}}, 2, 3, 5, {});
            }).find("loop"),
            std::string::npos);
  TriangleMesh tube = closed_tube();
  const std::vector<std::int32_t> ends = {1, 2};
  EXPECT_NE(refusal([&] {
              cut_off_end(tube, {{0, 0, 19}, Vec3(1, 0, 1).normalized()}, 3, 3, 5, ends);
            }).find("end"),
            std::string::npos);
  EXPECT_NE(refusal([&] {
              cut_off_end(tube, {{0, 0, 10}, {0, 0, 1}}, 1, 3, 5, ends);
            }).find("bulges"),
            std::string::npos);
  EXPECT_NE(refusal([&] {
              cut_off_end(tube, {{9, 0, 10}, {0, 0, 1}}, 3, 3, 5, ends);
            }).find("no vessel"),
            std::string::npos);
}

}  // namespace
}  // namespace lumesh::surfaces
