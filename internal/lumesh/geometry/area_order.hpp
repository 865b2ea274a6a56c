#pragma once
/// @file The order in which openings are numbered.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {

struct AreaAtPlace {
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
};

/// Area and centre of faces; their centres weigh as their areas, so that it does not matter how faces are
/// divided.
[[nodiscard]] inline AreaAtPlace area_at_place(const AreaSum& sum) {
  return {sum.area, sum.area > 0 ? sum.centre() : sum.moment};
}

/// Numbers of items by falling area; areas that differ by less than half a per cent count as equal, and are
/// ordered by their centres: by z, then y, then x, each ascending, where coordinates that differ by less than
/// a tenth of the radius count as equal, too. So the order is the same after rounding, but for areas that
/// happen to differ by just that much. Both compare with the first of the equal ones, so that a long row of
/// areas each of which is a little smaller falls into several groups, always the same.
[[nodiscard]] std::vector<std::size_t> order_by_area(std::span<const AreaAtPlace> given);

/// The items in that order.
/// @param measure  An item's AreaAtPlace.
template <class Item, class Measure>
void sort_by_area(std::vector<Item>& items, const Measure& measure) {
  std::vector<AreaAtPlace> measures;
  for (const Item& item : items) measures.push_back(measure(item));
  std::vector<Item> sorted;
  for (const std::size_t i : order_by_area(measures)) sorted.push_back(std::move(items[i]));
  items = std::move(sorted);
}

}  // namespace lumesh
