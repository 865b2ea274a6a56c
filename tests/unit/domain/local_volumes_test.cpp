// Places where the smooth boundary encloses another volume than the voxels, in vessels with and without.
#include "lumesh/domain/local_volumes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "fixtures/images.hpp"

namespace lumesh {
namespace {

/// An oblique vessel, whose area narrows by a share in its middle.
LabelImage vessel(double radius, double narrowing, double length) {
  const Vec3 through(15.6, 15.3, 20.7), axis = Vec3(0.12, -0.07, 1).normalized();
  return fixtures::voxels_of(fixtures::frame_of({32, 32, 42}), {0, 1}, [&](const Vec3& p) {
    const Vec3 off = p - through;
    const double along = off.dot(axis) / length, r = (off - off.dot(axis) * axis).norm();
    return r < radius * std::sqrt(1 - narrowing * std::exp(-along * along)) ? 1 : 0;
  });
}

std::vector<LocalVolume> changed(const LabelImage& image) {
  return find_changed_volumes(image, ImageDomain(image, {{}, {}}));
}

TEST(LocalVolumes, TellsThroatsThatTheBoundaryWidens) {
  const LabelImage image = vessel(2.4, 0.6, 3);
  const std::vector<LocalVolume> found = changed(image);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found[0].place_mm - Vec3(15.6, 15.3, 20.7)).norm(), 4);
  EXPECT_GT(found[0].change(), 0.15);
  EXPECT_LT(found[0].change(), 0.5);
  EXPECT_GT(found[0].voxels_mm3, 3.14 * 1.6 * 1.6 * 6);  // Of the throat alone.
  EXPECT_LT(found[0].voxels_mm3, 3.15 * 2.3 * 2.3 * 9);
  EXPECT_NE(doubt_about_volumes(image, ImageDomain(image, {{}, {}})).find("15 % or more in 1 place, most at"),
            std::string::npos);
}

TEST(LocalVolumes, SaysNothingOfVesselsWithoutOne) {
  for (const double radius : {1.6, 2.3, 3.1, 4.4, 7.0})
    EXPECT_TRUE(changed(vessel(radius, 0, 1)).empty()) << radius;
  EXPECT_TRUE(changed(vessel(6, 0.6, 9)).empty());
}

}  // namespace
}  // namespace lumesh
