// Openings of two labels in one plane: which of them lie in or around one another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/vessels/opening_sections.hpp"

namespace lumesh {
namespace {

/// Lines on labels of which an opening shares its outline with another one's.
template <class LabelAt>
std::vector<std::string> shared_lines(const LabelAt& label_at) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({50, 50, 30}), {0, 1, 2}, label_at);
  const ImageDomain domain(image, {});
  std::vector<std::string> lines = doubts_about_shapes(image, domain, find_openings(domain));
  std::erase_if(lines, [](const std::string& line) { return line.find("of its outline") == line.npos; });
  return lines;
}

double off_axis(const Vec3& p, double x, double y) {
  return std::hypot(p.x() - x - 0.03 * p.z(), p.y() - y);
}

/// A lumen of 1/6 of the area of the thrombus around it is too small for that to be known as a wall.
TEST(SharedOutlines, AThrombusAroundALumenIsTold) {
  const std::vector<std::string> lines = shared_lines([](const Vec3& p) {
    return off_axis(p, 24.2, 23.7) < 7 ? 1 : off_axis(p, 23, 24) < 18.5 ? 2 : 0;
  });
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].find("outlet_2_label_1 at"), 0U) << lines[0];
  EXPECT_NE(lines[0].find("_label_2 (1 of 2 such openings)"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("labels 1 and 2"), std::string::npos) << lines[0];
}

TEST(SharedOutlines, ThrombusBesideALumenIsTold) {
  for (const double off : {3.0, 5.0, 7.0, 9.0}) {
    const std::vector<std::string> lines = shared_lines([=](const Vec3& p) {
      return off_axis(p, 23, 24) > 14 ? 0 : off_axis(p, 23 - off, 24) < 11 ? 1 : 2;
    });
    EXPECT_EQ(lines.size(), 1U) << off;
  }
}

TEST(SharedOutlines, AWallAroundALumenIsKnown) {
  for (const double thickness : {1.5, 3.0, 6.0})
    EXPECT_TRUE(shared_lines([=](const Vec3& p) {
                  return off_axis(p, 23, 24) < 10 ? 1 : off_axis(p, 23, 24) < 10 + thickness ? 2 : 0;
                }).empty())
        << thickness;
}

/// Labels of arteries go over into one another inside, or run side by side.
TEST(SharedOutlines, VesselsThatTouchAreNotTold) {
  EXPECT_TRUE(shared_lines([](const Vec3& p) {
                return off_axis(p, 23, 24) > 9 ? 0 : p.z() < 14 ? 1 : 2;
              }).empty());
  for (const double radius : {2.5, 4.0, 8.0})
    for (const double apart : {1.6, 1.8, 2.0})
      EXPECT_TRUE(shared_lines([=](const Vec3& p) {
                    const double first = off_axis(p, 20, 24), second = off_axis(p, 20 + apart * radius, 25);
                    return std::min(first, second) > radius ? 0 : first < second ? 1 : 2;
                  }).empty())
          << radius << " " << apart;
}

}  // namespace
}  // namespace lumesh
