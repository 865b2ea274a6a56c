#include "lumesh/stages/domain_read.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/stages/vessel_ends.hpp"

namespace lumesh {
namespace {

/// A tube along z that leaves the image at both ends.
LabelImage straight_tube() {
  return fixtures::voxels_of(fixtures::frame_of({20, 20, 40}), {0, 1},
                             [](const Vec3& p) { return (p - Vec3(9.7, 9.6, p.z())).norm() < 6.2 ? 1 : 0; });
}

TEST(DomainRead, WithoutItsVoxelsAnImageHasItsDomainAndOpenings) {
  Context context;
  DomainRead given({}, context);
  given.image = straight_tube();
  EXPECT_EQ(given.image_domain(), nullptr) << "nobody has asked for it";
  const Domain& domain = given.domain();
  given.drop_image();
  EXPECT_FALSE(given.image.has_value());
  EXPECT_EQ(&given.domain(), &domain);
  EXPECT_EQ(given.openings().size(), 2U);
}

TEST(DomainRead, TheSurveyHasAxesWhereTheyAreWantedAndNothingToSayOfOpenVessels) {
  Context context;
  DomainRead given({}, context);
  given.image = straight_tube();
  const DomainRead::Survey plain = given.survey(false);
  EXPECT_TRUE(plain.axes.lines.empty());
  EXPECT_EQ(plain.closed_vessels, "");
  EXPECT_EQ(given.survey(true).axes.lines.size(), 1U);
}

/// A wide trunk that leaves the image at both ends, and a narrow branch that leaves it at a side.
LabelImage trunk_with_branch() {
  return fixtures::voxels_of(fixtures::frame_of({50, 40, 80}), {0, 1}, [](const Vec3& p) {
    const bool is_trunk = (p - Vec3(19.7, 20.1, p.z())).norm() < 9;
    const bool is_branch = p.x() > 19 && std::hypot(p.y() - 20, p.z() - 40.2) < 3.6;
    return is_trunk || is_branch ? 1 : 0;
  });
}

/// Whether the line begins or ends so near to an opening, in its plane.
bool has_tip_at(const Polylines& lines, const std::vector<std::uint32_t>& line, const Opening& opening) {
  return std::any_of(line.begin(), line.end(), [&](std::uint32_t p) {
    const bool is_tip = p == line.front() || p == line.back();
    const Vec3 off = lines.points[p] - opening.centre_mm;
    return is_tip && off.norm() < 0.6 && std::abs(off.dot(opening.normal)) < 0.01;
  });
}

/// What cuts leave behind their planes is no end of a vessel.
TEST(DomainRead, AxesEndInTheOpeningsOfWhatIsCutAndExtended) {
  const auto expect_between_openings = [](const InputCuts& cuts, const std::string& what) {
    Context context;
    DomainInput input;
    input.cuts = cuts;
    DomainRead given(input, context);
    given.image = trunk_with_branch();
    given.cut_image();
    const DomainRead::Survey survey = given.survey(true);
    const auto& lines = survey.axes.lines;
    ASSERT_EQ(given.openings().size(), 3U) << what;
    ASSERT_EQ(lines.size(), 2U) << what;
    for (const std::size_t trunk : {0, 1})
      EXPECT_TRUE(has_tip_at(survey.axes, lines[0], given.openings()[trunk])) << what << " " << trunk;
    EXPECT_TRUE(has_tip_at(survey.axes, lines[1], given.openings()[2])) << what;
    EXPECT_TRUE(vessel_ends(survey.axes, 1, given.openings()).empty()) << what;
  };
  expect_between_openings({.ends = local_length_from("1r")}, "clipped ends");
  expect_between_openings({.places_mm = {Vec3(19.7, 20.1, 12)}}, "one cut");
  expect_between_openings({.planes = {{Vec3(0, 0, 66.3), Vec3(0, 0.1, 2)}}}, "a plane");
  expect_between_openings({.extension = {named_lengths_from("3r"), {}}}, "extensions");
  expect_between_openings({.ends = local_length_from("1r"), .extension = {named_lengths_from("3r"), {}}},
                          "clipped ends with extensions");
}

/// Sizes at axes are those of each vessel, whether or not it joins the largest one.
TEST(DomainRead, EachVesselThatStandsAloneHasItsAxis) {
  std::string told;
  Context context({}, [&](std::string_view line) { told += line; });
  DomainRead given({}, context);
  given.image = fixtures::voxels_of(fixtures::frame_of({34, 20, 40}), {0, 1}, [](const Vec3& p) {
    const bool is_wide = std::hypot(p.x() - 8.7, p.y() - 9.6) < 6.2;
    const bool is_narrow = std::hypot(p.x() - 25.4, p.y() - 10.2) < 2.3;
    const bool is_ball = (p - Vec3(31, 3, 20)).norm() < 2.8;
    return is_wide || is_narrow || is_ball ? 1 : 0;
  });
  const Polylines axes = given.survey(true).axes;
  ASSERT_EQ(axes.lines.size(), 2U);
  for (const std::size_t vessel : {0, 1}) {
    const std::uint32_t middle = axes.lines[vessel][axes.lines[vessel].size() / 2];
    EXPECT_NEAR(axes.points[middle].x(), vessel == 0 ? 8.7 : 25.4, 0.3);
    EXPECT_NEAR(axes.scalars.at("radius")[middle], vessel == 0 ? 6.2 : 2.3, 0.3);
    EXPECT_EQ(axes.scalars.at("branch")[middle], vessel);
  }
  EXPECT_NE(told.find("1 of 3 pieces that stand alone, not longer than wide, without an axis"),
            std::string::npos)
      << told;
}

TEST(DomainRead, ErrorsNameTheFile) {
  Context context;
  DomainInput input;
  input.path = "tube.nrrd";
  input.cuts.places_mm = {Vec3(0.5, 0.5, 20)};
  DomainRead given(input, context);
  given.image = straight_tube();
  try {
    given.cut_image();
    FAIL() << "no vessel runs there";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("tube.nrrd: "), 0U) << error.what();
  }
}

}  // namespace
}  // namespace lumesh
