#include "lumesh/stages/vessel_ends.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/stages/input_cuts.hpp"

namespace lumesh {
namespace {

constexpr double kRadius = 5.2;
constexpr std::size_t kAll = ~std::size_t{0};

/// A tube along a slanted axis, with flat ends inside the image or beyond it.
LabelImage slanted_tube(double from, double to) {
  const Vec3 start(15, 16, 20), axis = Vec3(0.2, 0.1, 1).normalized();
  return fixtures::voxels_of(fixtures::frame_of({40, 36, 80}), {0, 1}, [=](const Vec3& p) {
    const double along = (p - start).dot(axis);
    return along > from && along < to && (p - start - along * axis).norm() < kRadius ? 1 : 0;
  });
}

std::vector<Opening> openings_of(const LabelImage& image) {
  return find_openings(ImageDomain(image, {}));
}

TEST(VesselEnds, AreFoundWhereThereIsNoOpening) {
  Context context;
  const LabelImage closed = slanted_tube(-10, 45), open = slanted_tube(-100, 100),
                   half = slanted_tube(-100, 40);
  EXPECT_EQ(vessel_ends(closed, {}, openings_of(closed), kAll, context).size(), 2U);
  EXPECT_TRUE(vessel_ends(open, {}, openings_of(open), kAll, context).empty());
  const std::vector<VesselEnd> ends = vessel_ends(half, {}, openings_of(half), kAll, context);
  ASSERT_EQ(ends.size(), 1U);
  EXPECT_NEAR(ends[0].radius_mm, kRadius, 0.5);
}

/// Where a branch leaves its parent, no vessel ends.
TEST(VesselEnds, AForkHasNone) {
  Context context;
  const LabelImage fork = fixtures::voxels_of(fixtures::frame_of({60, 24, 60}), {0, 1}, [](const Vec3& p) {
    const double across = p.y() - 11.6, up = p.z() - 30;
    const double trunk = std::hypot(p.x() - 29.4, across);
    const double arms = std::hypot(std::abs(p.x() - 29.4) - 0.8 * up, across);
    return (up < 0 && trunk < 5) || (up > -2 && arms < 4.2) ? 1 : 0;
  });
  EXPECT_EQ(openings_of(fork).size(), 3U);
  EXPECT_TRUE(vessel_ends(fork, {}, openings_of(fork), kAll, context).empty());
}

/// Vessels that are cut where the ends say have their section square to the axis.
TEST(VesselEnds, TheirPlacesCutSquare) {
  Context context;
  LabelImage image = slanted_tube(-10, 45);
  InputCuts cuts;
  for (const VesselEnd& end : vessel_ends(image, {}, {}, kAll, context))
    cuts.places_mm.push_back(place_from(cut_place_text(end.cut_mm.value())).value());
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, cuts, context);
  const std::vector<Opening> openings = find_openings(ImageDomain(image, options));
  ASSERT_EQ(openings.size(), 2U);
  for (const Opening& o : openings) {
    EXPECT_NEAR(o.area_mm2 / (std::numbers::pi * kRadius * kRadius), 1, 0.02);
    EXPECT_GT(std::abs(o.normal.dot(Vec3(0.2, 0.1, 1).normalized())), 0.998);
  }
}

/// Two arms that lean towards each other: at their tips each has the other one beside it.
TEST(VesselEnds, WhereTheTipCannotBeCutAPlaceUpTheVesselIsTold) {
  Context context;
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({70, 24, 90}), {0, 1}, [](const Vec3& p) {
    const double across = p.y() - 11.6, up = p.z() - 20;
    const double arms = std::hypot(std::abs(p.x() - 34.4) - (24 - 0.3 * up), across);
    const bool joint = std::abs(up) < 4.2 && std::abs(p.x() - 34.4) < 24 && std::abs(across) < 4.2;
    return joint || (up > 0 && up < 62.5 && arms < 4.2) ? 1 : 0;
  });
  const std::vector<VesselEnd> ends = vessel_ends(image, {}, {}, kAll, context);
  ASSERT_EQ(ends.size(), 2U);
  const auto is_refused = [&](const Vec3& place) {
    LabelImage copy = image;
    try {
      static_cast<void>(cut_off(copy, {{}, {place}}, context));
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  for (const VesselEnd& end : ends) {
    EXPECT_TRUE(is_refused(end.place_mm));
    ASSERT_TRUE(end.cut_mm) << end.refusal;
    EXPECT_FALSE(is_refused(*end.cut_mm));
    const double up_mm = (*end.cut_mm - end.place_mm).norm();
    EXPECT_GT(up_mm, 0.8 * end.radius_mm);
    EXPECT_LT(up_mm, 3 * end.radius_mm);
  }
}

/// The stump behind a cut is no end.
TEST(VesselEnds, AVesselThatIsCutThereHasNone) {
  Context context;
  LabelImage image = slanted_tube(-100, 40);
  ImageDomainOptions options;
  options.cut_planes =
      cut_off(image, {{}, {Vec3(15, 16, 20) + 25 * Vec3(0.2, 0.1, 1).normalized()}}, context);
  const std::vector<Opening> openings = find_openings(ImageDomain(image, options));
  ASSERT_EQ(openings.size(), 2U);
  EXPECT_TRUE(vessel_ends(image, options.cut_planes, openings, kAll, context).empty());
  EXPECT_EQ(dead_end_warning({}), "");
}

TEST(VesselEnds, ADeadEndBesideOpeningsIsToldWithThePlace) {
  Context context;
  const LabelImage half = slanted_tube(-100, 40);
  const std::vector<VesselEnd> ends = vessel_ends(half, {}, openings_of(half), kAll, context);
  ASSERT_EQ(ends.size(), 1U);
  EXPECT_EQ(dead_end_warning(ends).find("1 vessel ends inside the image and is closed there"), 0U);
  EXPECT_NE(dead_end_warning(ends).find("`cut_at` " + cut_place_text(ends[0].cut_mm.value())),
            std::string::npos);
}

TEST(VesselEnds, ClosedVesselsAreWarnedOfAndOthersNot) {
  Context context;
  const LabelImage closed = slanted_tube(-10, 45), half = slanted_tube(-100, 40);
  EXPECT_NE(closed_vessel_warning(closed, {}, {}, context)
                .find("2 end inside: cut the widest square with `cut_at`"),
            std::string::npos)
      << closed_vessel_warning(closed, {}, {}, context);
  EXPECT_EQ(
      closed_vessel_warning(half, {}, openings_of(half), context)
          .find(
              "\"inlet_1\" is the only opening, and nothing flows through a vessel with one; 1 ends inside"),
      0U);
  const LabelImage through = slanted_tube(-100, 100);
  EXPECT_EQ(closed_vessel_warning(through, {}, openings_of(through), context), "");
  const LabelImage ball = fixtures::voxels_of(fixtures::frame_of({24, 24, 24}), {0, 1}, [](const Vec3& p) {
    return (p - Vec3::Constant(11.6)).norm() < 8 ? 1 : 0;
  });
  EXPECT_EQ(closed_vessel_warning(ball, {}, {}, context), "") << "no vessel";
}

}  // namespace
}  // namespace lumesh
