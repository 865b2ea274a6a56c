// Flat caps where the image border or a cut plane ends the object.
#include <array>
#include <random>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/validate.hpp"
#include "shapes.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;
using test::expect_good;
using test::meshed;

const Vec3 kAxis(15.3, 15.6, 0);

double from_axis(const Vec3& p) {
  return std::hypot(p.x() - kAxis.x(), p.y() - kAxis.y());
}

/// A tube of radius 7 along z through the whole image.
LabelImage tube() {
  return voxels_of(frame_of({32, 32, 40}), {0, 1}, [](const Vec3& p) { return from_axis(p) < 7 ? 1 : 0; });
}

double area_of(const MixedMesh& mesh, const std::vector<Cell<3>>& triangles) {
  double area = 0;
  for (const Cell<3>& t : triangles) area += 0.5 * test::area_vector(mesh, t).norm();
  return area;
}

/// Vertices of a cap lie in its plane to rounding; on planes that are oblique to the lattice, where an angle
/// limit may hold a vertex back, all but a share of `max_held_back`, and those within a quarter of a voxel.
void expect_planar(const MixedMesh& mesh, const std::string& patch, const Vec3& point, const Vec3& normal,
                   double max_held_back = 0) {
  const auto triangles = test::triangles_of(mesh, patch);
  for (const Cell<3>& t : triangles)
    EXPECT_GT(test::area_vector(mesh, t).dot(normal), 0) << "the cap must face outwards";
  const auto vertices = test::vertices_of(triangles);
  std::size_t held_back = 0;
  for (const std::uint32_t v : vertices) {
    const double off = std::abs(normal.dot(mesh.points[v] - point));
    held_back += off > 1e-9 ? 1U : 0U;
    EXPECT_LE(off, 0.25);
  }
  EXPECT_LE(static_cast<double>(held_back), max_held_back * static_cast<double>(vertices.size()));
}

/// Vertices of wall and cap together: all on the circle where the tube meets the plane.
void expect_round_rim(const MixedMesh& mesh, const std::string& cap, double radius) {
  const auto wall = test::vertices_of(test::triangles_of(mesh, "wall"));
  std::size_t rim = 0;
  for (const std::uint32_t v : test::vertices_of(test::triangles_of(mesh, cap))) {
    if (wall.count(v) == 0) continue;
    ++rim;
    EXPECT_NEAR(from_axis(mesh.points[v]), radius, 1.0);
  }
  EXPECT_GE(rim, 10U);
}

TEST(Caps, ATubeIsCutFlatAtTheImageBorder) {
  const LabelImage image = tube();
  const MixedMesh mesh = meshed(image);
  expect_good(mesh);
  test::expect_label_volumes(image, mesh, 0.01);
  ASSERT_EQ(test::patch_names(mesh), (std::vector<std::string>{"inlet_1", "outlet_1", "wall"}));
  const auto inlet = test::triangles_of(mesh, "inlet_1");
  const bool below = mesh.points[inlet[0][0]].z() < 20;
  expect_planar(mesh, below ? "inlet_1" : "outlet_1", {0, 0, -0.5}, -Vec3::UnitZ());
  expect_planar(mesh, below ? "outlet_1" : "inlet_1", {0, 0, 39.5}, Vec3::UnitZ());
  const double circle = std::numbers::pi * 49;
  for (const char* cap : {"inlet_1", "outlet_1"}) {
    EXPECT_NEAR(area_of(mesh, test::triangles_of(mesh, cap)), circle, 0.03 * circle);
    EXPECT_EQ(test::euler_number(mesh, {test::patch_number(mesh, cap)}), 1) << "a disc";
    expect_round_rim(mesh, cap, 7);
    EXPECT_EQ(mesh.info.patches[static_cast<std::size_t>(test::patch_number(mesh, cap))].kind,
              PatchKind::kOpening);
  }
  EXPECT_EQ(test::euler_number(mesh, {test::patch_number(mesh, "wall")}), 0) << "an open cylinder";
  const auto wall = test::offsets_of(mesh, "wall", [](const Vec3& p) { return from_axis(p) - 7; });
  EXPECT_LE(wall.mean, 0.2);
  EXPECT_LE(wall.most, 1.0);
  // The wall stands upright on the cap.
  const auto radial = [](const Vec3& p) { return Vec3(p.x() - kAxis.x(), p.y() - kAxis.y(), 0); };
  EXPECT_LE(test::normal_error_deg(mesh, "wall", 0.95, radial), 15);
}

TEST(Caps, AnObliqueCutPlaneMakesAFlatCap) {
  const LabelImage image = tube();
  const Vec3 point(15.3, 15.6, 22);
  const Vec3 normal = Vec3(0.5, -0.3, 1).normalized();
  ImageDomainOptions options;
  options.cut_planes.push_back({point, 3 * normal});
  const MixedMesh mesh = meshed(image, {}, options);
  expect_good(mesh);
  ASSERT_EQ(test::patch_names(mesh), (std::vector<std::string>{"inlet_1", "outlet_1", "wall"}));
  for (const Vec3& p : mesh.points)
    EXPECT_LE(normal.dot(p - point), 0.25) << "nothing is left beyond the plane";
  // The ellipse of the oblique cut is larger than the circle at the border, so it is the inlet.
  expect_planar(mesh, "inlet_1", point, normal, 0.05);
  expect_planar(mesh, "outlet_1", {0, 0, -0.5}, -Vec3::UnitZ());
  const double ellipse = std::numbers::pi * 49 / normal.z();
  EXPECT_NEAR(area_of(mesh, test::triangles_of(mesh, "inlet_1")), ellipse, 0.03 * ellipse);
  expect_round_rim(mesh, "inlet_1", 7);
  // Below the plane the axis is 22.5 long, and the cut is symmetric about the axis.
  const double volume = std::numbers::pi * 49 * 22.5;
  EXPECT_NEAR(test::label_volumes(mesh).at(1), volume, 0.01 * volume);
}

/// Vessels with a wall (label 2) that leave through the image's faces askew: where lumen, wall, border and
/// outside meet, limits of 15 and 150 degrees held vertices back by up to a fifth of a voxel.
TEST(Caps, OfVesselsWithAWallThatLeaveAskewAreFlat) {
  std::mt19937 random(2026);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::size_t vertices = 0, off = 0;
  for (int n = 0; n < 6; ++n) {
    const Vec3 through(between(14, 18), between(14, 18), 16);
    const Vec3 along = Vec3(between(-0.8, 0.8), between(-0.8, 0.8), 1).normalized();
    const double lumen = between(4, 6);
    const LabelImage image = voxels_of(frame_of({32, 32, 32}), {0, 1, 2}, [&](const Vec3& p) {
      const double r = (p - through).cross(along).norm();
      return r < lumen ? 1 : r < lumen + 2.5 ? 2 : 0;
    });
    const MixedMesh mesh = meshed(image);
    EXPECT_TRUE(validate(mesh.view()).ok()) << validate(mesh.view()).text();
    for (std::size_t patch = 0; patch < mesh.info.patches.size(); ++patch) {
      if (mesh.info.patches[patch].kind != PatchKind::kOpening) continue;
      for (const std::uint32_t v :
           test::vertices_of(test::triangles_of(mesh, mesh.info.patches[patch].name))) {
        const Vec3& p = mesh.points[v];
        double nearest = 1e9;
        for (int k = 0; k < 3; ++k)
          nearest = std::min({nearest, std::abs(p[k] + 0.5), std::abs(p[k] - 31.5)});
        ++vertices;
        off += nearest > 1e-3 ? 1U : 0U;
      }
    }
  }
  EXPECT_GT(vertices, 1000U);
  EXPECT_EQ(off, 0U) << "of " << vertices;
}

TEST(Caps, AnObjectThatFillsTheImageIsABoxOfSixCaps) {
  ImageFrame frame = frame_of({24, 18, 15});
  frame.spacing_mm = {0.5, 0.5, 1};
  frame.direction = Eigen::AngleAxisd(0.7, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  const LabelImage image = voxels_of(frame, {0, 1}, [](const Vec3&) { return 1; });
  const MixedMesh mesh = meshed(image);
  expect_good(mesh);
  EXPECT_EQ(test::patch_names(mesh), (std::vector<std::string>{"inlet_1", "outlet_1", "outlet_2", "outlet_3",
                                                               "outlet_4", "outlet_5"}));
  EXPECT_NEAR(test::label_volumes(mesh).at(1), 12 * 9 * 15, 1e-6) << "edges and corners must be sharp";
  EXPECT_EQ(test::euler_number(mesh, {0, 1, 2, 3, 4, 5}), 2);
}

TEST(Caps, TwoVesselsThatLeaveThroughOneBorderGetTwoCaps) {
  const auto axis = [](const Vec3& p, double x) { return std::hypot(p.x() - x, p.y() - 11.6); };
  const LabelImage image = voxels_of(frame_of({44, 24, 20}), {0, 1}, [&](const Vec3& p) {
    return p.z() > 3.5 && (axis(p, 12.3) < 6 || axis(p, 31.4) < 5) ? 1 : 0;
  });
  const MixedMesh mesh = meshed(image);
  expect_good(mesh);
  ASSERT_EQ(test::patch_names(mesh), (std::vector<std::string>{"inlet_1", "outlet_1", "wall"}));
  for (const auto& [cap, x] : {std::pair("inlet_1", 12.3), std::pair("outlet_1", 31.4)}) {
    for (const std::uint32_t v : test::vertices_of(test::triangles_of(mesh, cap)))
      EXPECT_LT(axis(mesh.points[v], x), 7) << cap << ": the larger opening is the inlet";
  }
}

TEST(Caps, ACutBetweenVoxelsGivesTheVolumeInBetween) {
  const LabelImage image = tube();
  for (const double z : {20.05, 20.45, 20.55, 20.95}) {
    ImageDomainOptions options;
    options.cut_planes.push_back({{0, 0, z}, Vec3::UnitZ()});
    const double truth = std::numbers::pi * 49 * (z + 0.5);
    EXPECT_NEAR(test::label_volumes(meshed(image, {}, options)).at(1), truth, 0.01 * truth) << "cut at " << z;
  }
}

TEST(Caps, ACutPlaneThatLeavesNothingIsBadInput) {
  const LabelImage image = tube();
  ImageDomainOptions options;
  options.cut_planes.push_back({Vec3(0, 0, -100), Vec3::UnitZ()});
  try {
    (void)meshed(image, {}, options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
  }
}

/// Balls of two labels, some of which only graze the image's border.
LabelImage balls_at_the_border(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> along(-1, 24), radius(2, 7);
  std::array<Vec3, 6> centre;
  std::array<double, 6> reach{};
  for (std::size_t n = 0; n < centre.size(); ++n) {
    centre[n] = Vec3(along(random), along(random), along(random));
    reach[n] = radius(random);
    const int axis = static_cast<int>(n % 3);
    centre[n][axis] = n < 3 ? reach[n] - 0.4 : 23.4 - reach[n];  // Just reaches that border.
  }
  return voxels_of(frame_of({24, 24, 24}), {0, 1, 2}, [&](const Vec3& p) {
    int label = 0;
    for (std::size_t n = 0; n < centre.size(); ++n)
      if ((p - centre[n]).norm() < reach[n]) label = static_cast<int>(1 + n % 2);
    return label;
  });
}

TEST(Caps, NothingLeavesTheImage) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const MixedMesh mesh = meshed(balls_at_the_border(seed));
    double beyond = 0;
    for (const Vec3& p : mesh.points) beyond = std::max({beyond, -0.5 - p.minCoeff(), p.maxCoeff() - 23.5});
    EXPECT_LT(beyond, 1e-7);
  }
}

}  // namespace
}  // namespace lumesh
