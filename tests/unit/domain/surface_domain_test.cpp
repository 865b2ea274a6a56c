// The domain oracle of triangle surfaces against formulas.
#include "lumesh/domain/surface_domain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/patch_names.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fixtures::icosphere;
using fixtures::torus_surface;
using fixtures::TriangleSoup;
using fixtures::unit_cube_surface;

constexpr Material kInside = 1;

/// Signed distance to the cube [0, 1]^3, > 0 inside.
double depth_in_cube(const Vec3& x) {
  const Vec3 beyond = (x - Vec3::Constant(0.5)).cwiseAbs() - Vec3::Constant(0.5);
  return beyond.maxCoeff() <= 0 ? -beyond.maxCoeff() : -beyond.cwiseMax(0.0).norm();
}

Eigen::Isometry3d random_motion(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vec3 axis = Vec3(normal(random), normal(random), normal(random)).normalized();
  return Eigen::Translation3d(10 * normal(random), 10 * normal(random), 10 * normal(random)) *
         Eigen::AngleAxisd(normal(random), axis);
}

TriangleSoup moved(const TriangleSoup& soup, const Eigen::Isometry3d& motion) {
  return soup.moved([&](const Vec3& p) { return Vec3(motion * p); });
}

/// Places inside, far, and in all directions from faces, edges and corners, some exactly beside them.
std::vector<Vec3> places_around_cube(std::mt19937& random) {
  std::uniform_real_distribution<double> near(-0.5, 1.5), far(-8, 9), tiny(-1e-6, 1e-6), along(0, 1);
  std::vector<Vec3> places;
  for (int n = 0; n < 3000; ++n) {
    places.emplace_back(near(random), near(random), near(random));
    places.emplace_back(far(random), far(random), far(random));
    const Vec3 corner(n & 1, n >> 1 & 1, n >> 2 & 1);
    places.push_back(corner + Vec3(tiny(random), tiny(random), tiny(random)));
    Vec3 on_edge = corner;
    on_edge[n % 3] = along(random);
    places.push_back(on_edge + Vec3(tiny(random), tiny(random), tiny(random)));
  }
  for (const double x : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5})
    for (const double y : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5})
      for (const double z : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5}) places.emplace_back(x, y, z);
  return places;
}

/// The material over each face of the cube, found by asking far out.
std::array<Material, 6> materials_over_faces(const SurfaceDomain& domain, const Eigen::Isometry3d& motion) {
  std::array<Material, 6> result{};
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, 1}) {
      Vec3 x(0.51, 0.52, 0.53);
      x[axis] = side == 0 ? -1 : 2;
      result[static_cast<std::size_t>(2 * axis + side)] = domain.material_at(motion * x);
    }
  return result;
}

TEST(SurfaceDomain, NothingFarFromASurfaceThatCrossesItselfIsOnTheWrongSide) {
  // One point is moved over the triangles beside its own: the normals of what covers them point inwards.
  TriangleSoup folded = icosphere(3, 1);
  const Vec3 top = folded.points[100], aside = (top + 0.4 * top.unitOrthogonal()).normalized();
  folded.points[100] = 1.03 * aside;
  const SurfaceDomain domain(folded.view());
  std::mt19937 random(4);
  std::uniform_real_distribution<double> off(-0.4, 0.4), away(1.3, 30), within(0, 0.7);
  for (int n = 0; n < 5000; ++n) {
    const Vec3 way = (aside + Vec3(off(random), off(random), off(random))).normalized();
    const Vec3 outside = away(random) * way, inside = within(random) * way;
    ASSERT_NE(domain.material_at(outside), kInside) << outside.transpose();
    ASSERT_NE(domain.surroundings(outside).material, kInside) << outside.transpose();
    ASSERT_EQ(domain.material_at(inside), kInside) << inside.transpose();
  }
}

TEST(SurfaceDomain, MeasuresTheDistanceToACubeHoweverItIsTurned) {
  std::mt19937 random(1);
  for (int turn = 0; turn < 8; ++turn) {
    const Eigen::Isometry3d motion = turn == 0 ? Eigen::Isometry3d::Identity() : random_motion(random);
    const TriangleSoup cube = moved(unit_cube_surface(), motion);
    const SurfaceDomain domain(turn % 2 == 0 ? cube.view() : cube.reversed().view());
    for (const Vec3& place : places_around_cube(random)) {
      const double depth = depth_in_cube(place);
      const Domain::Surroundings here = domain.surroundings(motion * place);
      ASSERT_LE(here.clearance_mm, std::abs(depth) + 1e-13) << place.transpose();
      ASSERT_GE(here.clearance_mm, 0.9 * std::abs(depth) - 1e-13) << place.transpose();
      ASSERT_EQ(here.material, domain.material_at(motion * place));
      if (std::abs(depth) > 1e-13) {
        ASSERT_EQ(here.material == kInside, depth > 0) << place.transpose();
      }
    }
  }
}

TEST(SurfaceDomain, DividesTheOutsideOfACubeByItsFaces) {
  std::mt19937 random(2);
  for (int turn = 0; turn < 4; ++turn) {
    const Eigen::Isometry3d motion = turn == 0 ? Eigen::Isometry3d::Identity() : random_motion(random);
    const TriangleSoup cube = moved(unit_cube_surface(), motion);
    const SurfaceDomain domain(cube.view());
    ASSERT_EQ(domain.region_count(), 6u);
    const std::array<Material, 6> over = materials_over_faces(domain, motion);
    EXPECT_EQ(std::set<Material>(over.begin(), over.end()), (std::set<Material>{0, 2, 3, 4, 5, 6}));
    for (const Vec3& place : places_around_cube(random)) {
      Vec3 heights[2] = {-place, place - Vec3::Ones()};
      std::array<double, 6> height{};
      for (std::size_t f = 0; f < 6; ++f) height[f] = heights[f % 2][static_cast<int>(f / 2)];
      const auto highest =
          static_cast<std::size_t>(std::max_element(height.begin(), height.end()) - height.begin());
      const double most = height[highest];
      height[highest] = -1e9;
      if (most <= 1e-12 || *std::max_element(height.begin(), height.end()) > most - 1e-12) continue;
      ASSERT_EQ(domain.material_at(motion * place), over[highest]) << place.transpose();
    }
  }
}

TEST(SurfaceDomain, ProjectsToFacesEdgesAndCornersExactly) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> near(-0.3, 1.3);
  const Eigen::Isometry3d motion = random_motion(random);
  const TriangleSoup cube = moved(unit_cube_surface(), motion);
  const SurfaceDomain domain(cube.view());
  const std::array<Material, 6> over = materials_over_faces(domain, motion);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 place(near(random), near(random), near(random));
    const Vec3 clamped = place.cwiseMax(0.0).cwiseMin(1.0);
    // Face x = 1, then its edge with y = 0, then the corner with z = 1.
    Vec3 expected = clamped;
    MaterialSet set{kInside, over[1]};
    for (const auto& [axis, value, face] : {std::tuple{0, 1.0, 1u}, {1, 0.0, 2u}, {2, 1.0, 5u}}) {
      expected[axis] = value;
      set.insert(over[face]);
      const auto found = domain.project(motion * place, set, 5);
      ASSERT_TRUE(found);
      ASSERT_LT((motion.inverse() * *found - expected).norm(), 1e-13);
      ASSERT_TRUE(domain.materials_near(*found, 1e-9).contains_all(set));
      ASSERT_FALSE(domain.project(motion * place, set, 0.99 * (place - expected).norm()));
    }
  }
  EXPECT_FALSE(domain.project(motion * Vec3(0, 0, 0), {kInside, over[0], over[1]}, 10));
}

TEST(SurfaceDomain, FindsTheMaterialsThatAreNear) {
  const TriangleSoup cube = unit_cube_surface();
  const SurfaceDomain domain(cube.view());
  const std::array<Material, 6> over = materials_over_faces(domain, Eigen::Isometry3d::Identity());
  const auto near = [&](const Vec3& x, double reach) { return domain.materials_near(x, reach); };
  EXPECT_EQ(near({0.5, 0.5, 0.5}, 0.4), (MaterialSet{kInside}));
  EXPECT_EQ(near({0.9, 0.5, 0.5}, 0.2), (MaterialSet{kInside, over[1]}));
  EXPECT_EQ(near({0.9, 0.1, 0.5}, 0.2), (MaterialSet{kInside, over[1], over[2]}));
  EXPECT_EQ(near({0.9, 0.1, 0.9}, 0.2), (MaterialSet{kInside, over[1], over[2], over[5]}));
  EXPECT_EQ(near({1.3, 0.5, 0.5}, 0.2), (MaterialSet{over[1]}));
  EXPECT_EQ(near({1.1, 0.5, 0.5}, 0.2), (MaterialSet{kInside, over[1]}));
  EXPECT_EQ(near({0, 0, 0}, 0), (MaterialSet{kInside, over[0], over[2], over[4]}));
}

TEST(SurfaceDomain, SeparationsAreSignedDistancesWhoseGradientsPointToTheFirst) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> near(-0.5, 1.5);
  const TriangleSoup cube = unit_cube_surface();
  const SurfaceDomain domain(cube.view());
  const std::array<Material, 6> over = materials_over_faces(domain, Eigen::Isometry3d::Identity());
  for (int n = 0; n < 1000; ++n) {
    const Vec3 x(near(random), near(random), near(random));
    const Vec3 foot = Vec3(1, std::clamp(x.y(), 0.0, 1.0), std::clamp(x.z(), 0.0, 1.0));
    const FieldSample one = domain.separation(x, kInside, over[1]);
    const FieldSample other = domain.separation(x, over[1], kInside);
    ASSERT_NEAR(one.value, (depth_in_cube(x) > 0 ? 1 : -1) * (foot - x).norm(), 1e-14);
    ASSERT_EQ(one.value, -other.value);
    ASSERT_LT((x - one.value * one.gradient - foot).norm(), 1e-13);
    // Outside, the face over which x is higher comes first.
    const double higher = (x.x() - 1) - (-x.y());
    if (depth_in_cube(x) < 0 && x.x() > 1 && x.y() < 0 && std::abs(higher) > 1e-9) {
      ASSERT_EQ(domain.separation(x, over[1], over[2]).value > 0, higher > 0) << x.transpose();
    }
  }
  EXPECT_EQ(domain.separation({1, 0.3, 0.4}, kInside, over[1]).gradient, -Vec3::UnitX());
  EXPECT_EQ(domain.separation({1, 0.3, 0.4}, over[1], kInside).gradient, Vec3::UnitX());
}

TEST(SurfaceDomain, NeedleShapedEdgesDoNotConfuseTheSides) {
  // A wedge of 2 degrees: near its edge the nearest triangle alone does not tell the side.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> near(-0.2, 0.2), along(0.01, 0.99);
  const double slope = std::tan(std::numbers::pi / 180);
  const TriangleSoup wedge = unit_cube_surface().moved(
      [&](const Vec3& p) { return Vec3(p.x(), p.y(), (2 * p.z() - 1) * slope * (p.x() + 1e-3)); });
  const SurfaceDomain domain(wedge.view());
  for (int n = 0; n < 20000; ++n) {
    const Vec3 x(near(random), along(random), 0.05 * near(random));
    const bool is_inside = x.x() > 0 && std::abs(x.z()) < slope * (x.x() + 1e-3);
    ASSERT_EQ(domain.material_at(x) == kInside, is_inside) << x.transpose();
  }
}

TEST(SurfaceDomain, MeasuresRoundSurfacesToWithinTheirSagitta) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> anywhere(-4, 4);
  const Eigen::Isometry3d motion = random_motion(random);
  const TriangleSoup torus = moved(torus_surface(2, 0.7, 128, 48), motion);
  const SurfaceDomain domain(torus.view());
  EXPECT_EQ(domain.region_count(), 1u);
  EXPECT_NEAR(domain.volume_mm3(), 2 * std::pow(std::numbers::pi, 2) * 2 * 0.49, 0.07);
  EXPECT_NEAR(domain.area_mm2(), 4 * std::pow(std::numbers::pi, 2) * 2 * 0.7, 0.1);
  const double sagitta = 0.004;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 x(anywhere(random), anywhere(random), 0.5 * anywhere(random));
    const double depth = 0.7 - std::hypot(std::hypot(x.x(), x.y()) - 2, x.z());
    const Domain::Surroundings here = domain.surroundings(motion * x);
    ASSERT_LE(here.clearance_mm, std::abs(depth) + sagitta);
    ASSERT_GE(here.clearance_mm, 0.9 * std::abs(depth) - sagitta);
    ASSERT_EQ(here.material, domain.material_at(motion * x));
    if (std::abs(depth) > sagitta) {
      ASSERT_EQ(here.material, depth > 0 ? 1u : 0u);
    }
  }
}

TEST(SurfaceDomain, BoxesWithoutTheObjectAreTold) {
  const TriangleSoup ball = icosphere(4);
  const SurfaceDomain domain(ball.view());
  EXPECT_TRUE(domain.may_hold_object({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}));
  EXPECT_TRUE(domain.may_hold_object({0.9, -0.1, -0.1}, {1.1, 0.1, 0.1}));
  EXPECT_FALSE(domain.may_hold_object({0.8, 0.8, 0.8}, {1, 1, 1}));
  EXPECT_FALSE(domain.may_hold_object({3, 3, 3}, {4, 4, 4}));
  EXPECT_TRUE(domain.may_hold_object({-9, -9, -9}, {9, 9, 9}));
}

TEST(SurfaceDomain, ShellsWithinShellsAreCavities) {
  TriangleSoup shells = icosphere(3, 3);
  shells.append(icosphere(2, 2));  // Turned outwards, as its own file would be.
  shells.append(icosphere(2, 1).reversed());
  shells.append(icosphere(1, 0.5).moved([](const Vec3& p) { return Vec3(p + Vec3(5, 0, 0)); }));
  const SurfaceDomain domain(shells.view());
  EXPECT_EQ(domain.material_at({2.5, 0, 0}), kInside);
  EXPECT_FALSE(domain.is_meshed(domain.material_at({1.5, 0, 0})));
  EXPECT_EQ(domain.material_at({0, 0, 0}), kInside);
  EXPECT_EQ(domain.material_at({5, 0, 0}), kInside);
  EXPECT_FALSE(domain.is_meshed(domain.material_at({3.7, 0, 0})));
}

TEST(SurfaceDomain, NamesPatchesAsTheFileOrByAreaAndWallWhereThereIsOne) {
  const auto names_of = [](const SurfaceDomain& domain) {
    std::vector<std::string> names;
    for (Material m = 0; m < domain.material_count(); ++m)
      if (const auto patch = domain.patch_between(1, m)) names.push_back(patch->name);
    return names;
  };
  TriangleSoup box =
      unit_cube_surface().moved([](const Vec3& p) { return Vec3(p.x(), 2 * p.y(), 3 * p.z()); });
  EXPECT_EQ(names_of(SurfaceDomain(box.view())), std::vector<std::string>(6, "wall"));
  EXPECT_TRUE(names_of(SurfaceDomain(icosphere(3).view())).empty());
  // The file calls z = 0 and z = 3 "in" and "out", the other four sides "wall".
  box.patches = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 7, 7};
  const std::vector<Patch> info = {{"wall", PatchKind::kWall, {}}, {"in", PatchKind::kOpening, {}}};
  const SurfaceDomain domain({box.points, box.triangles, box.patches, info});
  EXPECT_EQ(names_of(domain), (std::vector<std::string>{"wall", "wall", "wall", "wall", "in", "patch_7"}));
  EXPECT_EQ(domain.patch_between(1, 5)->kind, PatchKind::kOpening);
  const std::vector<Patch> odd = {{"inlet_valve", PatchKind::kWall, {}},
                                  {"main_wall", PatchKind::kOpening, {}}};
  const SurfaceDomain oddly_named({box.points, box.triangles, box.patches, odd});
  EXPECT_EQ(oddly_named.patch_between(1, 5)->kind, PatchKind::kOpening) << "as its kind says, not its name";
  EXPECT_EQ(oddly_named.patch_between(1, 1 + 1)->kind, PatchKind::kWall);
  const std::vector<Patch> mirrored = {{"wall", PatchKind::kWall, {}}, {"in", PatchKind::kSymmetry, {}}};
  EXPECT_EQ(SurfaceDomain({box.points, box.triangles, box.patches, mirrored}).patch_between(1, 5)->kind,
            PatchKind::kSymmetry);
  const std::vector<BoundaryTriangle> faces = {
      {{0, 1, 2}, 1, 0}, {{0, 1, 3}, 1, 3}, {{0, 2, 3}, 1, 6}, {{1, 2, 3}, 1, 5}};
  const PatchAssignment named = name_patches(faces, box.points, domain);
  EXPECT_EQ(named.of_triangle, (std::vector<std::int32_t>{0, 1, 3, 2}));
  ASSERT_EQ(named.patches.size(),
            4u);  // Each side of the wall its own, so that meshers keep the edge between.
  for (const std::size_t wall : {0, 1}) EXPECT_EQ(named.patches[wall].name, "wall");
  EXPECT_EQ(named.patches[2].name, "in");
  EXPECT_EQ(named.patches[3].name, "patch_7");
}

TEST(SurfaceDomain, PatchesOfTheFileAreEndsThoughTheWallAroundIsFlat) {
  TriangleSoup box =
      unit_cube_surface().moved([](const Vec3& p) { return Vec3(p.x(), 2 * p.y(), 3 * p.z()); });
  box.patches = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 2};
  // As their kind says, or as face ids of a file.
  for (const PatchKind kind : {PatchKind::kOpening, PatchKind::kWall}) {
    const std::vector<Patch> info = {{"tube", PatchKind::kWall, {}}, {"in", kind, {}}, {"out", kind, {}}};
    const SurfaceDomain domain({box.points, box.triangles, box.patches, info});
    ASSERT_EQ(domain.flat_ends().size(), 2U);
    for (const FlatEnd& end : domain.flat_ends()) {
      EXPECT_TRUE(end.name == "in" || end.name == "out") << end.name;
      EXPECT_DOUBLE_EQ(end.area_mm2, 2);
      EXPECT_DOUBLE_EQ(std::abs(end.normal.z()), 1);
    }
  }
  // A piece of a flat side of the wall is no end, nor are the six sides of a box.
  box.patches = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0};
  const std::vector<Patch> piece = {{"tube", PatchKind::kWall, {}}, {"piece", PatchKind::kWall, {}}};
  EXPECT_TRUE(SurfaceDomain({box.points, box.triangles, box.patches, piece}).flat_ends().empty());
  box.patches = {0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};
  EXPECT_TRUE(SurfaceDomain({box.points, box.triangles, box.patches, {}}).flat_ends().empty());
  // Two of the six are said to be openings.
  std::vector<Patch> sides(6, {"side", PatchKind::kWall, {}});
  for (const std::size_t end : {4, 5}) sides[end] = {"end_" + std::to_string(end), PatchKind::kOpening, {}};
  EXPECT_EQ(SurfaceDomain({box.points, box.triangles, box.patches, sides}).flat_ends().size(), 2U);
}

TEST(SurfaceDomain, TheFeatureAngleDecidesWhatIsSharp) {
  const TriangleSoup ball = icosphere(0);  // 41.8 degrees between faces.
  EXPECT_EQ(SurfaceDomain(ball.view(), {.feature_angle_deg = 41}).region_count(), 20u);
  EXPECT_EQ(SurfaceDomain(ball.view(), {.feature_angle_deg = 42}).region_count(), 1u);
  EXPECT_EQ(SurfaceDomain(unit_cube_surface().view(), {.feature_angle_deg = 180}).region_count(), 1u);
}

TEST(SurfaceDomain, SpecksOfRoughSurfacesAreNoRegions) {
  TriangleSoup ball = icosphere(4);
  ball.points[700] *= 1.05;  // Steep triangles around one point.
  ball.points[900] *= 0.93;
  EXPECT_EQ(SurfaceDomain(ball.view(), {.feature_angle_deg = 40}).region_count(), 1u);
  // But not across the borders of patches.
  ball.patches.assign(ball.triangles.size(), 0);
  ball.patches[17] = 1;
  EXPECT_EQ(SurfaceDomain(ball.view(), {.feature_angle_deg = 40}).region_count(), 2u);
}

TEST(SurfaceDomain, JoinsEqualPointsAndLeavesOutWhatNoTriangleUses) {
  TriangleSoup soup;
  const TriangleSoup cube = unit_cube_surface();
  for (const Cell<3>& t : cube.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.points.size());
    for (const std::uint32_t v : t) soup.points.push_back(cube.points[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.points.emplace_back(100, std::numeric_limits<double>::quiet_NaN(), 0);
  soup.triangles.push_back({0, 0, 1});
  const SurfaceDomain domain(soup.view());
  EXPECT_EQ(domain.region_count(), 6u);
  EXPECT_NEAR(domain.volume_mm3(), 1, 1e-14);
  EXPECT_EQ(domain.bounds_mm().max(), Vec3::Ones());
}

TEST(SurfaceDomain, BearsTrianglesWithoutArea) {
  // The edge from corner 0 to corner 4 gets a point that only one of its triangles knows, and a flat
  // triangle.
  TriangleSoup cube = unit_cube_surface();
  cube.points.emplace_back(0, 0, 0.4);
  cube.triangles[0] = {8, 4, 6};
  cube.triangles.push_back({0, 8, 6});
  cube.triangles.push_back({0, 4, 8});
  std::mt19937 random(7);
  const SurfaceDomain domain(cube.view());
  EXPECT_EQ(domain.region_count(), 6u);
  for (const Vec3& place : places_around_cube(random)) {
    const double depth = depth_in_cube(place);
    if (std::abs(depth) > 1e-13) {
      ASSERT_EQ(domain.material_at(place) == kInside, depth > 0) << place.transpose();
    }
  }
}

TEST(SurfaceDomain, AnswersAlikeFromManyThreads) {
  const TriangleSoup ball = icosphere(3);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> anywhere(-1.5, 1.5);
  std::vector<Vec3> places(20000);
  for (Vec3& x : places) x = Vec3(anywhere(random), anywhere(random), anywhere(random));
  const auto answers = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const SurfaceDomain domain(ball.view(), {.feature_angle_deg = 5});
    std::vector<double> result(places.size());
    parallel::for_each_index(places.size(), [&](std::size_t i) {
      const Domain::Surroundings here = domain.surroundings(places[i]);
      result[i] = here.clearance_mm + 10 * here.material;
    });
    return result;
  };
  const std::vector<double> one = answers(1);
  EXPECT_EQ(answers(2), one);
  EXPECT_EQ(answers(8), one);
}

struct BrokenSurface {
  const char* name;
  void (*damage)(TriangleSoup& cube);
  const char* message;
};
class BrokenSurfaces : public testing::TestWithParam<BrokenSurface> {};

TEST_P(BrokenSurfaces, AreRefusedWithTheirPlace) {
  TriangleSoup cube = unit_cube_surface();
  GetParam().damage(cube);
  try {
    const SurfaceDomain domain(cube.view());
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_NE(std::string(error.what()).find(GetParam().message), std::string::npos) << error.what();
  }
}

/// Five vertices in a strip that comes back turned over.
TriangleSoup moebius_strip_closed() {
  // The projective plane with six points: closed, two triangles at each edge, one side.
  TriangleSoup plane;
  for (int i = 0; i < 6; ++i) plane.points.emplace_back(std::cos(i), std::sin(2 * i), std::cos(3 * i));
  plane.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                     {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  return plane;
}

INSTANTIATE_TEST_SUITE_P(
    SurfaceDomain, BrokenSurfaces,
    testing::Values(
        BrokenSurface{"Empty", [](TriangleSoup& s) { s = {}; }, "has no triangles"},
        BrokenSurface{"Open", [](TriangleSoup& s) { s.triangles.pop_back(); },
                      "3 edges have one triangle only, such as that from (0, 0, 1) to (0, 1, 1) mm"},
        BrokenSurface{"Fin",
                      [](TriangleSoup& s) {
                        s.points.emplace_back(2, 2, 2);
                        s.triangles.push_back({0, 1, 8});
                      },
                      "the edge from (0, 0, 0) to (1, 0, 0) mm has 3 triangles"},
        BrokenSurface{
            "TouchingPoints",
            [](TriangleSoup& s) { s.append(s.moved([](const Vec3& p) { return Vec3(p + Vec3::Ones()); })); },
            "touches itself in the point (1, 1, 1) mm"},
        BrokenSurface{"CrossingShells",
                      [](TriangleSoup& s) {
                        s.append(s.moved([](const Vec3& p) { return Vec3(p + Vec3(0.5, 0.4, 0.3)); }));
                      },
                      "crosses or touches itself: "},
        BrokenSurface{"CrossingItself", [](TriangleSoup& s) { s = torus_surface(1, 1.6, 24, 16); },
                      "crosses or touches itself: "},
        BrokenSurface{"OneSide", [](TriangleSoup& s) { s = moebius_strip_closed(); }, "one side only"},
        BrokenSurface{"Flat",
                      [](TriangleSoup& s) {
                        s = s.moved(
                            [](const Vec3& p) { return Vec3(p.x() + 0.5 * p.z(), p.y() - p.z(), 0); });
                      },
                      "the surface encloses nothing, such as at ("},
        BrokenSurface{"FlatPart",
                      [](TriangleSoup& s) {
                        const auto first = static_cast<std::uint32_t>(s.points.size());
                        const TriangleSoup flat = s.moved(
                            [](const Vec3& p) { return Vec3(90 + p.x() + 0.5 * p.z(), p.y() - p.z(), 0); });
                        s.points.insert(s.points.end(), flat.points.begin(), flat.points.end());
                        for (const Cell<3>& t : flat.triangles)
                          s.triangles.push_back({first + t[0], first + t[1], first + t[2]});
                      },
                      "(`lumesh repair`)"},
        BrokenSurface{"NaN", [](TriangleSoup& s) { s.points[5].y() = NAN; }, "point 5 is not finite"},
        BrokenSurface{"MissingPoint", [](TriangleSoup& s) { s.triangles[3][1] = 99; },
                      "triangle 3 of the surface: point 99 does not exist"},
        BrokenSurface{"Patches",
                      [](TriangleSoup& s) {
                        s.patches = {1, 2};
                      },
                      "12 triangles but 2 patch numbers"}),
    [](const testing::TestParamInfo<BrokenSurface>& info) { return std::string(info.param.name); });

TEST(SurfaceDomain, RefusesBadOptions) {
  EXPECT_THROW(SurfaceDomain(unit_cube_surface().view(), {.feature_angle_deg = 0}), Error);
  EXPECT_THROW(SurfaceDomain(unit_cube_surface().view(), {.feature_angle_deg = NAN}), Error);
}

}  // namespace
}  // namespace lumesh
