// Openings against sections that are known exactly, and meshes of which parts are taken away.
#include "lumesh/domain/openings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "fixtures/analytic_domain.hpp"
#include "fixtures/images.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/patch_names.hpp"
#include "lumesh/image/touching.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

TEST(FindOpenings, KnowsTheEllipsesOfASlantedTube) {
  const Vec3 on_axis(0.4, -0.3, 0.2), axis = Vec3(0.3, -0.2, 1).normalized();
  const double radius = 2.5;
  for (const double angle_deg : {90.0, 55.0, 30.0}) {
    const double angle = angle_deg * std::numbers::pi / 180;  // Between the axis and the planes.
    const Vec3 normal = std::sin(angle) * axis + std::cos(angle) * axis.unitOrthogonal();
    fixtures::AnalyticDomainOptions options;
    options.bounds_mm = Box3(Vec3::Constant(-20), Vec3::Constant(20));
    options.resolution_mm = 1;
    options.cut_planes = {{on_axis - 8 * axis, -normal}, {on_axis + 8 * axis, normal}};
    const fixtures::AnalyticDomain domain({{7, fixtures::cylinder_shape(on_axis, axis, radius)}}, options);
    const std::vector<Opening> openings = find_openings(domain);
    ASSERT_EQ(openings.size(), 2U) << angle_deg;
    for (const Opening& opening : openings) {
      const double area = std::numbers::pi * radius * radius / std::sin(angle);
      EXPECT_NEAR(opening.area_mm2 / area, 1, 5e-4) << angle_deg;
      EXPECT_NEAR(opening.radius_mm(), std::sqrt(area / std::numbers::pi), 5e-3 * radius);
      EXPECT_EQ(opening.label, 7);
      const double side = opening.normal.dot(normal);  // The one above, or the one below.
      EXPECT_NEAR(std::abs(side), 1, 1e-12);
      EXPECT_LT((opening.centre_mm - (on_axis + side * 8 * axis)).norm(), 0.02);
    }
  }
}

/// The sides of rectangles run along the squares that openings are measured by.
TEST(FindOpenings, KnowsRectanglesHoweverNarrow) {
  for (const Vec3& sides : {Vec3(37, 8, 3), Vec3(29.3, 4.4, 21.7), Vec3(11.1, 10.3, 1.9)}) {
    ImageFrame frame = fixtures::frame_of({5, 5, 5});
    frame.spacing_mm = sides / 5;
    const LabelImage all = fixtures::voxels_of(frame, {0, 1}, [](const Vec3&) { return 1; });
    const std::vector<Opening> openings = find_openings(ImageDomain(all, {}));
    ASSERT_EQ(openings.size(), 6U);
    for (const Opening& opening : openings) {
      const double along = sides.dot(opening.normal.cwiseAbs());
      EXPECT_NEAR(opening.area_mm2 * along / sides.prod(), 1, 1e-3)
          << sides.transpose() << ", " << opening.name;
    }
  }
}

TEST(FindOpenings, SeparatedVesselsHaveSectionsOfTheirOwn) {
  // Side by side all along, with a common area one to five voxels broad.
  const Vec3 axis = Vec3(0.09, 0.07, 1).normalized(), across = Vec3(1, 0.3, 0).cross(axis).cross(axis);
  const double radius = 6;
  for (const double overlap : {0.1, 0.4, 0.8, 1.2}) {
    const Vec3 to_axis = (radius - overlap / 2) * across.normalized(), middle(22.3, 20.2, 15);
    LabelImage image = fixtures::voxels_of(fixtures::frame_of({46, 42, 32}), {0, 1}, [&](const Vec3& p) {
      const auto off = [&](const Vec3& from) { return (p - from).cross(axis).norm(); };
      return std::min(off(middle + to_axis), off(middle - to_axis)) <= radius ? 1 : 0;
    });
    separate_touching(image);
    const std::vector<Opening> openings = find_openings(ImageDomain(image, {}));
    ASSERT_EQ(openings.size(), 4U) << overlap;
    // At most half the common part is gone, and a voxel and a half beside it.
    const double kept = radius - overlap / 2 - 1.5, angle = std::acos(kept / radius),
                 cut_off = radius * radius * angle - kept * radius * std::sin(angle),
                 section = std::numbers::pi * radius * radius;
    for (const Opening& o : openings) {
      EXPECT_LT(o.area_mm2 * axis.z(), 1.02 * section) << overlap;
      EXPECT_GT(o.area_mm2 * axis.z(), section - cut_off) << overlap;
    }
  }
}

/// Three tubes of radii 6, 4 and 3 along z, of which the second ends inside, and a ball that only touches a
/// border.
LabelImage several() {
  return fixtures::voxels_of(fixtures::frame_of({60, 40, 24}), {0, 1, 2}, [](const Vec3& p) {
    const auto off = [&](double x, double y) { return std::hypot(p.x() - x, p.y() - y); };
    if (off(10.3, 12.2) < 6) return 1;
    if (off(30.1, 12.4) < 4 && p.z() < 14) return 1;
    if (off(45.2, 25.3) < 3) return 2;
    return (p - Vec3(30, 30, 26.3)).norm() < 3 ? 1 : 0;  // One voxel of it is in the last slice.
  });
}

TEST(FindOpenings, TellsSeveralApartByFallingArea) {
  const LabelImage image = several();
  const ImageDomain domain(image, {});
  const std::vector<Opening> openings = find_openings(domain);
  ASSERT_GE(openings.size(), 5U);
  const std::array<double, 5> radii = {6, 6, 4, 3, 3};
  for (std::size_t i = 0; i < radii.size(); ++i) {
    EXPECT_NEAR(openings[i].radius_mm(), radii[i], 0.02 * radii[i]) << i;
    EXPECT_EQ(openings[i].label, i < 3 ? 1 : 2);
    EXPECT_NEAR(std::abs(openings[i].normal.z()), 1, 1e-12);
  }
  EXPECT_LT(openings[2].normal.z(), 0) << "the tube that ends inside";
  for (std::size_t i = 5; i < openings.size(); ++i) EXPECT_LT(openings[i].area_mm2, 5) << "the ball's tip";
}

TEST(FindOpenings, AreasThatAgreeAreOrderedByPlace) {
  fixtures::AnalyticDomainOptions options;
  options.bounds_mm = Box3(Vec3::Constant(-20), Vec3::Constant(20));
  options.resolution_mm = 1;
  options.cut_planes = {{Vec3(0, 0, 8), Vec3(0, 0, 1)}, {Vec3(0, 0, -8), Vec3(0, 0, -1)}};
  for (const double share : {0.9992, 1.0, 1.0008}) {  // Of the radius; 0.16 % of the area.
    const fixtures::AnalyticDomain domain(
        {{1, fixtures::cylinder_shape(Vec3(6.1, 0.2, 0), Vec3(0, 0, 1), 3 * share)},
         {2, fixtures::cylinder_shape(Vec3(-6.1, -0.2, 0), Vec3(0, 0, 1), 3)}},
        options);
    const std::vector<Opening> openings = find_openings(domain);
    ASSERT_EQ(openings.size(), 4U) << share;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 wanted(i % 2 == 0 ? -6.1 : 6.1, i % 2 == 0 ? -0.2 : 0.2, i < 2 ? -8 : 8);
      EXPECT_LT((openings[i].centre_mm - wanted).norm(), 0.1) << share << openings[i].name;
    }
  }
}

/// Names of the openings found, five at most.
std::vector<std::string> names_in(const LabelImage& image) {
  std::vector<std::string> names;
  for (const Opening& o : find_openings(ImageDomain(image, {}))) names.push_back(o.name);
  names.resize(5);
  return names;
}

TEST(FindOpenings, NamesWithSeveralLabelsHaveTheLabelOrWhatTheImageCallsIt) {
  LabelImage image = several();
  using Names = std::vector<std::string>;
  EXPECT_EQ(names_in(image), (Names{"inlet_1_label_1", "outlet_1_label_1", "outlet_2_label_1",
                                    "outlet_3_label_2", "outlet_4_label_2"}));
  image.label_names() = {{1, "left ICA (C7)"}, {2, "2"}};
  EXPECT_EQ(names_in(image), (Names{"inlet_1_left_ICA_C7", "outlet_1_left_ICA_C7", "outlet_2_left_ICA_C7",
                                    "outlet_3_label_2", "outlet_4_label_2"}));
}

/// A tube of radius 6 along z with a wall, or with something in it, of the given radius around its axis.
LabelImage tube_with(double radius) {
  return fixtures::voxels_of(fixtures::frame_of({30, 30, 16}), {0, 1, 2}, [&](const Vec3& p) {
    const double off = std::hypot(p.x() - 14.3, p.y() - 14.6);
    if (radius < 6 && off < radius) return 2;
    return off < 6 ? 1 : off < radius ? 2 : 0;
  });
}

TEST(FindOpenings, RimsOfWallsAreNoOutlets) {
  for (const double radius : {7.7, 10.0}) {  // The thicker wall has more area than the lumen.
    std::vector<std::string> of_lumen, of_wall;
    for (const Opening& o : find_openings(ImageDomain(tube_with(radius), {})))
      (o.label == 1 ? of_lumen : of_wall).push_back(o.name);
    EXPECT_EQ(of_lumen, (std::vector<std::string>{"inlet_1", "outlet_1"})) << radius;
    EXPECT_EQ(of_wall, (std::vector<std::string>{"wall_rim_1", "wall_rim_2"})) << radius;
  }
}

TEST(FindOpenings, AWallThatAnEdgeOfTheImageCutsHasRimsInBothFaces) {
  const Vec3 on_axis(8, -0.5, 20), axis = Vec3(1, 1, 0).normalized();
  const LabelImage image =
      fixtures::voxels_of(fixtures::frame_of({40, 40, 40}), {0, 1, 2}, [&](const Vec3& x) {
        const double off = (x - on_axis).cross(axis).norm();
        return off < 4 ? 1 : off < 7 ? 2 : 0;
      });
  std::size_t beside_no_lumen = 0;  // In the face x = -0.5, 6 mm off the axis.
  for (const Opening& o : find_openings(ImageDomain(image, {}))) {
    EXPECT_EQ(o.is_rim, o.label == 2) << o.name;
    beside_no_lumen += o.label == 2 && o.normal.x() < -0.9 ? 1U : 0U;
  }
  EXPECT_EQ(beside_no_lumen, 1U);
}

TEST(FindOpenings, WhatLiesInALumenMakesNoRimOfIt) {
  for (const Opening& o : find_openings(ImageDomain(tube_with(2.2), {}))) EXPECT_FALSE(o.is_rim) << o.name;
}

std::size_t count_rims(const LabelImage& image) {
  const std::vector<Opening> openings = find_openings(ImageDomain(image, {}));
  return static_cast<std::size_t>(std::ranges::count_if(openings, &Opening::is_rim));
}

TEST(FindOpenings, AThrombusIsAWallAtBothEndsOrAtNone) {
  // Its ring is three times the lumen's section at one end, and five times at the other; open at one side.
  const auto thrombus = [](double shift) {
    return fixtures::voxels_of(fixtures::frame_of({40, 40, 50}), {0, 1, 2}, [=](const Vec3& p) {
      const double lumen = 6 - 0.02 * p.z(), off = std::hypot(p.x() - 19.6 - shift * p.z(), p.y() - 19.3);
      return off < lumen ? 1 : std::hypot(p.x() - 19.6, p.y() - 19.3) < 12.2 ? 2 : 0;
    });
  };
  EXPECT_EQ(count_rims(thrombus(0)), 2U);
  EXPECT_EQ(count_rims(thrombus(0.16)), 2U) << "the ring is open at one end";
}

TEST(FindOpenings, AVoxelBesideAnOpeningIsNotTakenForIt) {
  // A crescent, of which the last voxel of a tip touches the rest over an edge.
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({40, 40, 20}), {0, 1, 2}, [](const Vec3& p) {
    const bool in_tube = std::hypot(p.x() - 20, p.y() - 20) < 12;
    return !in_tube ? 0 : std::hypot(p.x() - 16, p.y() - 20) < 9.4 ? 1 : 2;
  });
  for (int z = 0; z < 20; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        if (image.at({x, y, z}) == 2 && x < 13 && y > 20) image.at({x, y, z}) = (x + y) % 2 == 0 ? 2 : 1;
  std::size_t faces = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) faces += image.at({x, y, 0}) == 2 ? 1U : 0U;
  double largest_mm2 = 0;
  for (const Opening& o : find_openings(ImageDomain(image, {})))
    if (o.label == 2) largest_mm2 = std::max(largest_mm2, o.area_mm2);
  EXPECT_GT(largest_mm2, 0.8 * static_cast<double>(faces));
}

TEST(FindOpenings, GivesTheSameBitsForEveryNumberOfThreads) {
  const LabelImage image = several();
  const auto found = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return find_openings(ImageDomain(image, {}));
  };
  const auto one = found(1), many = found(5);
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].area_mm2, many[i].area_mm2);
    EXPECT_EQ(one[i].centre_mm, many[i].centre_mm);
  }
}

TEST(FindOpenings, ThereAreNoneWithoutCuts) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({20, 20, 20}), {0, 1}, [](const Vec3& p) {
    return (p - Vec3::Constant(9.4)).norm() < 6 ? 1 : 0;
  });
  EXPECT_TRUE(find_openings(ImageDomain(image, {})).empty());
}

/// A square of two triangles at z = 23.5, facing up.
MixedMesh square(const std::string& name, const Vec3& centre, double edge) {
  MixedMesh mesh;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    mesh.points.push_back(centre + 0.5 * edge * Vec3(x, y, 0));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_patches = {0, 0};
  mesh.info.patches = {{name, PatchKind::kOpening, {1, kBackground}}};
  return mesh;
}

TEST(CompareOpenings, SaysWhatIsMissingWrongOrNone) {
  const Box3 box(Vec3(4, 4, 23.5), Vec3(16, 16, 23.5));
  std::vector<Opening> openings = {
      {1, 100, Vec3(10, 10, 23.5), Vec3::UnitZ(), box},
      {1, 40, Vec3(40, 10, 23.5), Vec3::UnitZ(), Box3(Vec3(37, 7, 23.5), Vec3(43, 13, 23.5))}};
  openings[1].name = "outlet_1";
  const MixedMesh good = square("inlet_1", Vec3(10, 10, 23.5), 10);
  const OpeningsCompared one = compare_openings(good.view(), openings);
  EXPECT_EQ(one.openings[0].patches, "inlet_1");
  EXPECT_NEAR(one.openings[0].change_percent(), 0, 1e-9);
  EXPECT_FALSE(is_wrong(one.openings[0]));
  EXPECT_TRUE(is_wrong(one.openings[1]));
  ASSERT_EQ(doubts_about(one).size(), 1U);
  EXPECT_EQ(doubts_about(one)[0],
            "outlet_1, an opening of 40 mm² at (40.0, 10.0, 23.5) mm, is missing in the mesh");

  const MixedMesh small = square("outlet_9", Vec3(40, 10, 23.5), 6);
  const std::vector<std::string> doubts = doubts_about(compare_openings(small.view(), openings));
  ASSERT_EQ(doubts.size(), 2U);
  EXPECT_EQ(doubts[1], "outlet_9 has 36 mm², 10.0 % less than the input's 40 mm² at (40.0, 10.0, 23.5) mm");

  const MixedMesh elsewhere = square("outlet_1", Vec3(25, 30, 23.5), 6);
  const OpeningsCompared none = compare_openings(elsewhere.view(), openings);
  EXPECT_EQ(none.others, std::vector<std::string>{"outlet_1"});
  EXPECT_EQ(doubts_about(none).size(), 3U);
}

/// Squares of 1 mm that hold 0 < x, y < 8 mm at z = 0, without 3 < x, y < 5 mm.
Opening square_with_hole() {
  OpeningSquares squares{
      Vec3(0.5, 0.5, 0), Vec3::UnitX(), Vec3::UnitY(), 1, 8, 8, std::vector<std::uint8_t>(64, 1)};
  for (const int column : {3, 4})
    for (const int row : {3, 4}) squares.is_inside[squares.square(column, row)] = 0;
  Opening opening{1, 60, Vec3(4, 4, 0), Vec3::UnitZ(), Box3(Vec3(0, 0, 0), Vec3(8, 8, 0))};
  opening.squares = std::make_shared<const OpeningSquares>(std::move(squares));
  opening.name = "inlet_1";
  return opening;
}

/// Triangles of 1 mm of the plane where `holds` says so of a square's column and row.
template <class Holds>
MixedMesh plate(const Holds& holds) {
  MixedMesh mesh;
  for (int y = 0; y <= 8; ++y)
    for (int x = 0; x <= 8; ++x) mesh.points.emplace_back(x, y, 0);
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) {
      if (!holds(static_cast<int>(x), static_cast<int>(y))) continue;
      const std::uint32_t v = x + 9 * y;
      mesh.triangles.insert(mesh.triangles.end(), {{v, v + 1, v + 10}, {v, v + 10, v + 9}});
    }
  mesh.triangle_patches.assign(mesh.triangles.size(), 0);
  mesh.info.patches = {{"inlet_1", PatchKind::kOpening, {1, kBackground}}};
  return mesh;
}

TEST(CompareOpenings, TellsPartsRimsAndWhatIsNotFlat) {
  const std::vector<Opening> openings = {square_with_hole()};
  EXPECT_EQ(openings[0].squares->hole_areas_mm2(), std::vector<double>{4});
  const auto is_hole = [](int x, int y) { return (x == 3 || x == 4) && (y == 3 || y == 4); };
  MixedMesh mesh = plate([&](int x, int y) { return !is_hole(x, y); });
  const OpeningsCompared good = compare_openings(mesh.view(), openings);
  EXPECT_TRUE(doubts_about(good).empty());
  EXPECT_EQ(good.openings[0].shape.rims, 2U);
  EXPECT_EQ(good.openings[0].shape.edges, 8U);
  mesh.points[0].z() = 0.009;  // Voxels of 1 mm.
  EXPECT_TRUE(doubts_about(compare_openings(mesh.view(), openings)).empty());
  mesh.points[0].z() = 0.02;
  const OpeningsCompared bent = compare_openings(mesh.view(), openings);
  EXPECT_FALSE(is_wrong(bent.openings[0]));
  EXPECT_EQ(doubts_about(bent),
            std::vector<std::string>{"inlet_1 is not flat: (0.0, 0.0, 0.0) mm is 0.02 mm off its plane"});
  // Two squares beside the hole are missing: 3.3 % less.
  const OpeningsCompared torn =
      compare_openings(plate([&](int x, int y) {
                         return !is_hole(x, y) && !(x == 4 && y == 2) && !(x == 3 && y == 5);
                       }).view(),
                       openings);
  EXPECT_EQ(faults_of(torn).size(), 0U);
  EXPECT_EQ(doubts_about(torn).size(), 1U);
  const OpeningsCompared halves =
      compare_openings(plate([&](int x, int y) { return x != 4 && !is_hole(x, y); }).view(), openings);
  ASSERT_EQ(faults_of(halves).size(), 1U);
  EXPECT_EQ(faults_of(halves)[0],
            "inlet_1 has 54 mm², 10.0 % less than the input's 60 mm² at (4.0, 4.0, 0.0) mm, in 2 parts");
}

TEST(CompareOpenings, TellsEndsThatAreLessFlatThanTheSurfaces) {
  std::vector<Opening> openings = {square_with_hole()};
  openings[0].is_of_surface = true;
  MixedMesh mesh = plate([](int x, int y) { return x < 3 || x > 4 || y < 3 || y > 4; });
  EXPECT_TRUE(doubts_about(compare_openings(mesh.view(), openings)).empty());
  mesh.points[0].z() = 1e-5;
  EXPECT_EQ(doubts_about(compare_openings(mesh.view(), openings)),
            std::vector<std::string>{"inlet_1 is not flat: (0.0, 0.0, 0.0) mm is 1e-05 mm off its plane"});
  openings[0].off_mm = 1e-5;
  EXPECT_TRUE(doubts_about(compare_openings(mesh.view(), openings)).empty());
}

TEST(CompareOpenings, WallsThatAreCalledSymmetryAreNone) {
  const std::vector<Opening> openings = {
      {1, 100, Vec3(10, 10, 23.5), Vec3::UnitZ(), Box3(Vec3(4, 4, 23.5), Vec3(16, 16, 23.5))}};
  // A lid over the opening, bent up behind it: its middle looks as the opening does, and part of it lies
  // there.
  MixedMesh mesh = square("inlet_1", Vec3(10, 10, 23.5), 10);
  mesh.points.insert(mesh.points.end(), {{15, 5, 29}, {15, 15, 29}});
  mesh.triangles.insert(mesh.triangles.end(), {{1, 2, 4}, {2, 5, 4}, {0, 1, 2}});
  mesh.triangle_patches.insert(mesh.triangle_patches.end(), {1, 1, 1});
  mesh.info.patches.push_back({"wall", PatchKind::kSymmetry, {1, kBackground}});
  // A true plane of symmetry elsewhere.
  mesh.points.insert(mesh.points.end(), {{30, 0, 0}, {30, 9, 0}, {30, 0, 9}});
  mesh.triangles.push_back({6, 7, 8});
  mesh.triangle_patches.push_back(2);
  mesh.info.patches.push_back({"middle", PatchKind::kSymmetry, {1, kBackground}});
  const OpeningsCompared compared = compare_openings(mesh.view(), openings);
  EXPECT_TRUE(compared.others.empty());
  EXPECT_EQ(compared.openings[0].patches, "inlet_1");
  EXPECT_TRUE(doubts_about(compared).empty());
}

/// Two pieces of one opening have one name, a sliver elsewhere on the border is wall, and a missing opening
/// keeps its number.
TEST(NamePatches, FollowsTheOpeningsOfTheDomain) {
  const LabelImage image = several();
  const ImageDomain domain(image, {});
  Material top = 0;
  for (Material m = domain.label_count(); m < domain.material_count(); ++m)
    if (domain.cut_plane(m).normal.z() > 0.5) top = m;
  ASSERT_GT(top, 0U);
  std::vector<Vec3> positions;
  std::vector<BoundaryTriangle> triangles;
  const auto add = [&](Material label, double x, double y, double edge) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const Vec3& off : {Vec3(0, 0, 0), Vec3(edge, 0, 0), Vec3(0, edge, 0)})
      positions.push_back(Vec3(x, y, 23.5) + off);
    triangles.push_back({{first, first + 1, first + 2}, label, top});
  };
  add(2, 44, 24, 3);  // The tube of radius 3: outlet_3 or outlet_4.
  add(1, 8, 10, 4);   // Two pieces of the largest one.
  add(1, 12, 14, 2);
  add(1, 52, 5, 0.5);  // Of nothing.
  const PatchAssignment named = name_patches(triangles, positions, domain);
  const auto name_of = [&](std::size_t t) {
    return named.patches[static_cast<std::size_t>(named.of_triangle[t])].name;
  };
  EXPECT_TRUE(name_of(0) == "outlet_3_label_2" || name_of(0) == "outlet_4_label_2") << name_of(0);
  EXPECT_TRUE(name_of(1) == "inlet_1_label_1" || name_of(1) == "outlet_1_label_1") << name_of(1);
  EXPECT_EQ(name_of(2), name_of(1));
  EXPECT_EQ(named.patches[static_cast<std::size_t>(named.of_triangle[3])].kind, PatchKind::kWall);
  positions[triangles[2].vertices[0]].z() -= 0.2;
  positions[triangles[1].vertices[0]].z() -= 0.3;
  const PatchAssignment bent = name_patches(triangles, positions, domain);
  const auto kind_of = [&](std::size_t t) {
    return bent.patches[static_cast<std::size_t>(bent.of_triangle[t])].kind;
  };
  EXPECT_EQ(kind_of(2), PatchKind::kOpening);
  EXPECT_EQ(kind_of(1), PatchKind::kWall) << "openings are flat";
}

/// A mesh may join what lies side by side in a plane, as where a wall between two sections hardly leaves it.
TEST(NamePatches, SplitsAtOpeningsWhatTheMeshHasJoined) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({40, 22, 20}), {0, 1}, [](const Vec3& p) {
    return std::min(std::hypot(p.x() - 12, p.y() - 10), std::hypot(p.x() - 26, p.y() - 10)) < 6 ? 1 : 0;
  });
  const ImageDomain domain(image, {});
  Material top = 0;
  for (Material m = domain.label_count(); m < domain.material_count(); ++m)
    if (domain.cut_plane(m).normal.z() > 0.5) top = m;
  ASSERT_GT(top, 0U);
  std::vector<Vec3> positions;
  std::vector<BoundaryTriangle> triangles;
  const auto corner = [&](int i, int j) { return static_cast<std::uint32_t>(i + 29 * j); };
  for (int j = 0; j <= 12; ++j)
    for (int i = 0; i <= 28; ++i) positions.emplace_back(5 + i, 4 + j, 19.5);  // Around both.
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 28; ++i) {
      triangles.push_back({{corner(i, j), corner(i + 1, j), corner(i, j + 1)}, 1, top});
      triangles.push_back({{corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)}, 1, top});
    }
  const PatchAssignment named = name_patches(triangles, positions, domain);
  std::map<std::string, std::vector<double>> x_of;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    x_of[named.patches[static_cast<std::size_t>(named.of_triangle[t])].name].push_back(
        positions[triangles[t].vertices[0]].x());
  ASSERT_EQ(x_of.size(), 2U);
  const auto& [first, second] = std::pair(x_of.begin()->second, x_of.rbegin()->second);
  EXPECT_NEAR(static_cast<double>(first.size()), static_cast<double>(second.size()), 0.05 * second.size());
  const bool is_first_below = first[0] < second[0];
  EXPECT_LE(std::ranges::max(is_first_below ? first : second), 20);
  EXPECT_GE(std::ranges::min(is_first_below ? second : first), 17);
}

/// Triangles between two circles around the origin, with 48 corners each; a disc where the inner one is a
/// point.
FlatEnd ring(const std::string& name, double inner, double outer, const Vec3& normal) {
  constexpr int kAround = 48;
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  const auto at = [&](double radius, int i) {
    const double angle = 2 * std::numbers::pi * i / kAround;
    return Vec3(radius * (std::cos(angle) * u + std::sin(angle) * v));
  };
  FlatEnd end{name,
              0.5 * kAround * std::sin(2 * std::numbers::pi / kAround) * (outer * outer - inner * inner),
              Vec3::Zero(),
              normal,
              {},
              {}};
  for (int i = 0; i < kAround; ++i) {
    end.triangles_mm.push_back({at(inner, i), at(outer, i), at(outer, i + 1)});
    if (inner > 0) end.triangles_mm.push_back({at(inner, i), at(outer, i + 1), at(inner, i + 1)});
    end.box_mm.extend(at(outer, i));
  }
  return end;
}

TEST(OpeningOfPlaces, KnowsADiscFromTheRingAroundIt) {
  const Vec3 normal = Vec3(0.2, -0.4, 1).normalized();
  const std::vector<FlatEnd> ends = {ring("disc", 0, 4, normal), ring("ring", 5, 6, normal)};
  const std::vector<Opening> openings = openings_of(ends, 0.5);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    std::vector<Vec3> places;
    for (const auto& triangle : ends[e].triangles_mm)
      places.emplace_back((triangle[0] + triangle[1] + triangle[2]) / 3);
    EXPECT_EQ(opening_of_places(openings, 1, places, normal), e);
    EXPECT_NEAR(openings[e].perimeter_mm() / (2 * std::numbers::pi * (e == 0 ? 4 : 11)), 1, 0.03);
  }
}

}  // namespace
}  // namespace lumesh
