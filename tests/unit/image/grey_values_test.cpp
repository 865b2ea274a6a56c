#include "lumesh/image/grey_values.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lumesh {
namespace {

/// Where two groups of one width stand far apart, the best threshold is anywhere between them.
TEST(GreyValues, TheThresholdPartsTwoGroups) {
  std::mt19937 random(7);
  std::normal_distribution<float> dark(-100, 10), bright(300, 10);
  std::vector<float> values;
  for (int i = 0; i < 30000; ++i) values.push_back(dark(random));
  for (int i = 0; i < 10000; ++i) values.push_back(bright(random));
  const GreyValues grey = grey_values(std::span<const float>(values));
  EXPECT_GT(grey.otsu_threshold(), -60);
  EXPECT_LT(grey.otsu_threshold(), 260);
  EXPECT_NEAR(grey.share_from(grey.otsu_threshold()), 0.25, 1e-3);
  EXPECT_EQ(grey.count, values.size());
}

TEST(GreyValues, RangeLeavesOutWhatIsNoNumber) {
  const std::vector<double> values = {2, std::nan(""), -1, INFINITY, 5};
  const GreyValues grey = grey_values(std::span<const double>(values));
  EXPECT_EQ(grey.least, -1);
  EXPECT_EQ(grey.most, 5);
  EXPECT_EQ(grey.count, 3U);
  EXPECT_EQ(grey.bins.front(), 1U);
  EXPECT_EQ(grey.bins.back(), 1U);
}

TEST(GreyValues, OfOneValueOrNone) {
  const std::vector<int> same(10, 3);
  const GreyValues grey = grey_values(std::span<const int>(same));
  EXPECT_EQ(grey.otsu_threshold(), 3);
  EXPECT_EQ(grey.share_from(3), 1);
  EXPECT_EQ(grey_values(std::span<const int>()).count, 0U);
}

}  // namespace
}  // namespace lumesh
