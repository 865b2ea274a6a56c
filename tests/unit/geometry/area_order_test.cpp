#include "lumesh/geometry/area_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace lumesh {
namespace {

using Order = std::vector<std::size_t>;

TEST(AreaOrder, LargerAreasComeFirst) {
  EXPECT_EQ(order_by_area(std::vector<AreaAtPlace>{{1, {0, 0, 0}}, {3, {0, 0, 9}}, {2, {0, 0, 5}}}),
            (Order{1, 2, 0}));
}

TEST(AreaOrder, AreasThatAgreeAreOrderedByPlaceWhateverRoundingSays) {
  for (const double change : {-1e-3, -1e-9, 0.0, 1e-9, 1e-3}) {
    const std::vector<AreaAtPlace> items = {{3 + change, {7 - change, 1 + change, 20 - change}},
                                            {3, {7, 1 - change, -2}},
                                            {3 - change, {1, 1, 20 + change}},
                                            {3 + change, {2 + change, 0, 20 - change}}};
    EXPECT_EQ(order_by_area(items), (Order{1, 3, 2, 0})) << change;
  }
}

/// 100 areas, each a thousandth smaller than the one before; places say the opposite.
TEST(AreaOrder, ALongRowOfAreasFallsIntoTheSameGroupsInEveryOrder) {
  std::vector<AreaAtPlace> items;
  for (int i = 0; i < 100; ++i) items.push_back({10 * std::pow(0.999, i), {0, 0, 100.0 * (100 - i)}});
  const auto areas = [](const std::vector<AreaAtPlace>& given) {
    std::vector<double> sorted;
    for (const std::size_t i : order_by_area(given)) sorted.push_back(given[i].area_mm2);
    return sorted;
  };
  const std::vector<double> first = areas(items);
  std::ranges::rotate(items, items.begin() + 37);
  EXPECT_EQ(areas(items), first);
  std::ranges::reverse(items);
  EXPECT_EQ(areas(items), first);
  for (std::size_t i = 1; i < first.size(); ++i) EXPECT_LT(first[i], first[i - 1] / (1 - 5e-3));
  EXPECT_LT(first.back(), 0.92 * first.front());
}

/// Sums over surfaces of an absurd size overflow.
TEST(AreaOrder, EndsWithWhatIsNotFinite) {
  constexpr double kInf = std::numeric_limits<double>::infinity(),
                   kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<AreaAtPlace> items = {{1, {0, 0, kNaN}}, {kNaN, {0, 0, 0}}, {2, {kInf, 0, -kInf}},
                                          {kInf, {0, 0, 0}}, {1, {0, kNaN, 3}}, {2, {1, 0, 0}}};
  Order order = order_by_area(items);
  EXPECT_EQ(order, order_by_area(items));
  EXPECT_EQ(order[2] + order[3], 7U);  // Those of 2 mm2, behind those that overflow.
  std::ranges::sort(order);
  EXPECT_EQ(order, (Order{0, 1, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace lumesh
