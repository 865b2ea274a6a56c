#include "lumesh/stages/domain_read.hpp"

#include <gtest/gtest.h>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"

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
