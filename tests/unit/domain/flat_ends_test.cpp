// Flat ends of closed surfaces, which are openings, and what is none.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "fixtures/surfaces.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/surface_domain.hpp"

namespace lumesh {
namespace {

using fixtures::TriangleSoup;
using fixtures::unit_cube_surface;

/// A tube along z of the given radii at its ends, closed by fans around a middle.
TriangleSoup capped_tube(double radius, double end_radius, double tilt, std::uint32_t around = 24) {
  constexpr std::uint32_t kAlong = 12;
  TriangleSoup soup;
  for (std::uint32_t k = 0; k <= kAlong; ++k)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double share = static_cast<double>(k) / kAlong, angle = 2 * std::numbers::pi * i / around;
      const double r = radius + share * (end_radius - radius), x = r * std::cos(angle);
      soup.points.emplace_back(x, r * std::sin(angle), 8 * share + tilt * share * x);
    }
  const auto at = [around](std::uint32_t k, std::uint32_t i) { return k * around + i % around; };
  for (std::uint32_t k = 0; k < kAlong; ++k)
    for (std::uint32_t i = 0; i < around; ++i) {
      soup.triangles.push_back({at(k, i), at(k, i + 1), at(k + 1, i)});
      soup.triangles.push_back({at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)});
    }
  const auto low = static_cast<std::uint32_t>(soup.points.size());
  soup.points.emplace_back(0, 0, 0), soup.points.emplace_back(0, 0, 8);
  for (std::uint32_t i = 0; i < around; ++i) {
    soup.triangles.push_back({at(0, i + 1), at(0, i), low});
    soup.triangles.push_back({at(kAlong, i), at(kAlong, i + 1), low + 1});
  }
  return soup;
}

/// Names of a tube do not depend on rounding.
TEST(SurfaceDomain, EndsOfOneAreaAreOrderedByPlace) {
  for (const double end_radius : {2 * (1 - 1e-3), 2 * (1 - 1e-7), 2.0, 2 * (1 + 1e-7), 2 * (1 + 1e-3)}) {
    const std::vector<Opening> openings = find_openings(SurfaceDomain(capped_tube(2, end_radius, 0).view()));
    ASSERT_EQ(openings.size(), 2U) << end_radius;
    EXPECT_EQ(openings[0].name, "inlet_1");
    EXPECT_LT(openings[0].centre_mm.z(), 1) << end_radius;
    EXPECT_GT(openings[1].centre_mm.z(), 7) << end_radius;
  }
}

TEST(SurfaceDomain, FlatEndsOfTubesAreOpenings) {
  for (const double tilt : {0.0, 0.5}) {
    const SurfaceDomain domain(capped_tube(2, 1.5, tilt).view());
    const std::vector<Opening> openings = find_openings(domain);
    ASSERT_EQ(openings.size(), 2U) << tilt;
    EXPECT_EQ(openings[0].name, "inlet_1");
    EXPECT_EQ(openings[1].name, "outlet_1");
    const double polygon =
        12 * std::sin(2 * std::numbers::pi / 24);  // Area of 24 corners on the unit circle.
    EXPECT_NEAR(openings[0].area_mm2, 4 * polygon, 1e-9);
    EXPECT_NEAR(openings[1].area_mm2, 2.25 * polygon * std::sqrt(1 + tilt * tilt), 1e-9);
    EXPECT_LT((openings[1].centre_mm - Vec3(0, 0, 8)).norm(), 1e-9);
    EXPECT_NEAR(openings[1].normal.dot(Vec3(-tilt, 0, 1).normalized()), 1, 1e-9);
    std::map<std::string, PatchKind> kinds;
    for (Material m = 0; m < domain.material_count(); ++m)
      if (const auto patch = domain.patch_between(1, m)) kinds[patch->name] = patch->kind;
    EXPECT_EQ(kinds, (std::map<std::string, PatchKind>{{"wall", PatchKind::kWall},
                                                       {"inlet_1", PatchKind::kOpening},
                                                       {"outlet_1", PatchKind::kOpening}}));
  }
}

/// One of radius 2 whose rims are up to 3.5 % of that off their planes.
TriangleSoup tube_with_ragged_rims(std::uint32_t around, double length_mm = 8) {
  TriangleSoup tube = capped_tube(2, 2, 0, around);
  for (Vec3& p : tube.points) p.z() *= length_mm / 8;
  for (const std::uint32_t row : {0U, 12U})
    for (std::uint32_t i = 0; i < around; ++i)
      tube.points[row * around + i].z() += 0.07 * std::cos(2.399 * i * i + row);
  return tube;
}

// As a sac drawn around a few slices of voxels: what is behind its flat sides are its other sides.
TEST(SurfaceDomain, RaggedSidesOfADiscAreNoEnds) {
  const double side_mm2 = 4 * std::numbers::pi;
  const SurfaceDomain disc(tube_with_ragged_rims(48, 1).view());
  for (const FlatEnd& end : disc.flat_ends()) EXPECT_LT(end.area_mm2, 0.8 * side_mm2);
}

// Sharp edges between the triangles of its fan made an end several openings, or none.
TEST(SurfaceDomain, AnEndOverARaggedRimIsOneOpening) {
  for (const std::uint32_t around : {48U, 64U}) {
    TriangleSoup tube = tube_with_ragged_rims(around);
    const SurfaceDomain domain(tube.view());
    ASSERT_EQ(domain.flat_ends().size(), 2U) << around;
    for (const FlatEnd& end : domain.flat_ends()) {
      EXPECT_GT(end.area_mm2, 0.99 * 4 * std::numbers::pi) << around;
      EXPECT_LT(end.area_mm2, 1.15 * 4 * std::numbers::pi) << around;
      EXPECT_GT(std::abs(end.normal.z()), 0.99);
    }
    EXPECT_EQ(domain.region_count(), 3U) << around;
    tube.patches.assign(tube.triangles.size(), 0);
    for (std::size_t t = tube.triangles.size() - 2 * around; t < tube.triangles.size(); ++t)
      tube.patches[t] = t % 2 == 0 ? 1 : 2;
    const std::vector<Patch> info = {
        {"vessel", PatchKind::kWall, {}}, {"ica", PatchKind::kWall, {}}, {"mca", PatchKind::kWall, {}}};
    const SurfaceDomain named({tube.points, tube.triangles, tube.patches, info});
    std::set<std::string> names;
    for (const FlatEnd& end : named.flat_ends()) names.insert(end.name);
    EXPECT_EQ(names, (std::set<std::string>{"ica", "mca"})) << around;
  }
}

TEST(SurfaceDomain, AnEndCutOffVeryObliquelyIsToldOf) {
  const TriangleSoup oblique = capped_tube(2, 1.5, 1.8);  // 61 degrees from square.
  const SurfaceDomain domain(oblique.view());
  ASSERT_EQ(domain.flat_ends().size(), 1U);
  ASSERT_EQ(domain.patch_notes().size(), 1U);
  EXPECT_NE(domain.patch_notes()[0].find("0.0, 8.0) mm"), std::string::npos) << domain.patch_notes()[0];
  EXPECT_NE(domain.patch_notes()[0].find("obliquely"), std::string::npos);
  EXPECT_EQ(SurfaceDomain(oblique.view(), {.feature_angle_deg = 20}).flat_ends().size(), 2U);
  EXPECT_TRUE(SurfaceDomain(capped_tube(2, 1.5, 0.5).view()).patch_notes().empty());
}

TEST(SurfaceDomain, AnEndTooBentToBeOneIsToldOf) {
  TriangleSoup tube = capped_tube(2, 2, 0);
  tube.points.back().z() += 0.5;  // The tip of a cone then, a third of which lies below its centre.
  const SurfaceDomain domain(tube.view());
  ASSERT_EQ(domain.flat_ends().size(), 1U);
  ASSERT_EQ(domain.patch_notes().size(), 1U);
  EXPECT_NE(domain.patch_notes()[0].find("8.2) mm, of radius 1.99 mm"), std::string::npos)
      << domain.patch_notes()[0];
  EXPECT_NE(domain.patch_notes()[0].find("0.33 mm off a plane"), std::string::npos);
}

// With one flat end besides, each was told of; without, none.
TEST(SurfaceDomain, EndsThatAreAllTooBentAreToldOf) {
  TriangleSoup tube = capped_tube(2, 2, 0);
  tube.points.back().z() += 0.5;
  tube.points[tube.points.size() - 2].z() -= 0.5;
  const SurfaceDomain domain(tube.view());
  EXPECT_TRUE(domain.flat_ends().empty());
  EXPECT_EQ(domain.patch_notes().size(), 2U);
}

TEST(SurfaceDomain, FlatSidesBehindWhichTheObjectEndsAreNoEnds) {
  TriangleSoup disc = capped_tube(2, 2, 0);
  for (Vec3& p : disc.points) p.z() *= 1.0 / 8;
  const SurfaceDomain domain(disc.view());
  EXPECT_TRUE(domain.flat_ends().empty());
  ASSERT_EQ(domain.patch_notes().size(), 1U);
  EXPECT_NE(domain.patch_notes()[0].find("2 flat pieces"), std::string::npos) << domain.patch_notes()[0];
  for (Vec3& p : disc.points) p.z() *= 1.5;
  EXPECT_EQ(SurfaceDomain(disc.view()).flat_ends().size(), 2U);
}

// Each was an opening without a word, at the side of a tube of few triangles that ends raggedly.
TEST(SurfaceDomain, FacetsOfTheWallAreNoEnds) {
  const TriangleSoup tube = fixtures::tube_of_rows(4, 13, [](std::uint32_t row, std::uint32_t i) {
    const std::array<double, 4> rim = {-0.4, 0.03, 0.35, 0.25};
    const double angle = std::numbers::pi / 2 * (i + 0.5 * row);
    return Vec3(std::cos(angle), std::sin(angle), row == 0 ? rim[i] : 20 * row / 12.0);
  });
  const SurfaceDomain domain(tube.view());
  EXPECT_TRUE(domain.flat_ends().empty());
  ASSERT_EQ(domain.patch_notes().size(), 1U);
  EXPECT_NE(domain.patch_notes()[0].find("4 flat pieces"), std::string::npos) << domain.patch_notes()[0];
}

TEST(SurfaceDomain, AFlatStepOfTheWallIsNoEnd) {
  const TriangleSoup tube = fixtures::tube_of_rows(128, 101, [](std::uint32_t row, std::uint32_t i) {
    const double angle = 2 * std::numbers::pi * i / 128, x = 2 * std::cos(angle), y = 2 * std::sin(angle),
                 z = 8 * row / 100.0;
    return Vec3(x > 0 && std::hypot(y, z - 4) < 0.5 ? 2.1 : x, y, z);
  });
  const SurfaceDomain domain(tube.view());
  ASSERT_EQ(domain.flat_ends().size(), 2U);
  for (const FlatEnd& end : domain.flat_ends()) EXPECT_GT(std::abs(end.normal.z()), 0.99);
  ASSERT_EQ(domain.patch_notes().size(), 1U);
  EXPECT_NE(domain.patch_notes()[0].find("goes past behind"), std::string::npos) << domain.patch_notes()[0];
}

TEST(SurfaceDomain, FlatEndsKeepTheNamesOfTheFile) {
  TriangleSoup tube = capped_tube(2, 1.5, 0);
  tube.patches.assign(tube.triangles.size(), 0);
  for (std::size_t t = tube.triangles.size() - 48; t < tube.triangles.size(); ++t)
    tube.patches[t] = t % 2 == 0 ? 1 : 2;
  const std::vector<Patch> info = {
      {"vessel", PatchKind::kWall, {}}, {"ica", PatchKind::kWall, {}}, {"end_wall", PatchKind::kWall, {}}};
  const SurfaceDomain domain({tube.points, tube.triangles, tube.patches, info});
  ASSERT_EQ(domain.flat_ends().size(), 1U);
  EXPECT_EQ(domain.flat_ends()[0].name, "ica");
}

TEST(SurfaceDomain, SidesOfABoxAndRingsAreNoEnds) {
  EXPECT_TRUE(SurfaceDomain(unit_cube_surface().view()).flat_ends().empty());
  // A thick-walled tube: its ends are rings.
  TriangleSoup walls = capped_tube(2, 2, 0);
  const TriangleSoup inner = capped_tube(1, 1, 0).reversed();
  const auto keep_sides = [](TriangleSoup soup) {
    soup.triangles.resize(soup.triangles.size() - 48);
    return soup;
  };
  TriangleSoup both = keep_sides(walls);
  const auto first = static_cast<std::uint32_t>(both.points.size());
  both.append(keep_sides(inner));
  for (std::uint32_t i = 0; i < 24; ++i)
    for (const std::uint32_t k : {0U, 12U * 24U}) {
      const std::uint32_t a = k + i, b = k + (i + 1) % 24, c = first + a, d = first + b;
      if (k == 0)
        both.triangles.push_back({b, a, c}), both.triangles.push_back({b, c, d});
      else
        both.triangles.push_back({a, b, c}), both.triangles.push_back({b, d, c});
    }
  EXPECT_TRUE(SurfaceDomain(both.view()).flat_ends().empty());
}

TEST(SurfaceDomain, FlatEndsOfABodyInTheLumenAreNoOpenings) {
  TriangleSoup soup = capped_tube(2, 2, 0);
  TriangleSoup rod = capped_tube(0.5, 0.5, 0);
  for (Vec3& p : rod.points) p.z() = 2 + 0.5 * p.z();  // Half as long, within.
  ASSERT_EQ(SurfaceDomain(soup.view()).flat_ends().size(), 2U);
  soup.append(rod);
  const SurfaceDomain domain(soup.view());
  ASSERT_EQ(domain.flat_ends().size(), 2U);
  for (const FlatEnd& end : domain.flat_ends()) EXPECT_NEAR(end.area_mm2, 12.4, 0.3);  // A disc of 2 mm.
}

}  // namespace
}  // namespace lumesh
