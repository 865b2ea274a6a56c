#include "lumesh/geometry/area_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh {
namespace {

/// Calls visit(run) for the longest runs of sorted items whose values are near that of the first of them.
template <class IsNear, class Visit>
void for_each_run(std::span<std::size_t> items, const IsNear& is_near, const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
    ++end;  // The first is of its run, whatever is_near() says.
    while (end < items.size() && is_near(items[begin], items[end])) ++end;
    visit(items.subspan(begin, end - begin));
  }
}

/// By a coordinate, and where it is the same within the reach by those before it.
void sort_by_place(std::span<const AreaAtPlace> all, int axis, double reach_mm,
                   std::span<std::size_t> items) {
  const auto at = [&](std::size_t i) { return all[i].centre_mm[axis]; };
  std::ranges::stable_sort(items, [&](std::size_t a, std::size_t b) { return at(a) < at(b); });
  if (axis == 0) return;
  for_each_run(
      items, [&](std::size_t first, std::size_t other) { return at(other) - at(first) <= reach_mm; },
      [&](std::span<std::size_t> run) { sort_by_place(all, axis - 1, reach_mm, run); });
}

/// Numbers that can be compared, for what overflows in surfaces of absurd size.
AreaAtPlace finite(const AreaAtPlace& item) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const auto clamped = [&](double x) { return std::isnan(x) ? kMost : std::clamp(x, -kMost, kMost); };
  return {clamped(item.area_mm2), item.centre_mm.unaryExpr(clamped)};
}

}  // namespace

std::vector<std::size_t> order_by_area(std::span<const AreaAtPlace> given) {
  constexpr double kSameArea = 5e-3, kSamePlace = 0.1;  // Of the area; of the radius.
  std::vector<AreaAtPlace> items;
  for (const AreaAtPlace& item : given) items.push_back(finite(item));
  std::vector<std::size_t> order(items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return items[a].area_mm2 > items[b].area_mm2; });
  for_each_run(
      std::span(order),
      [&](std::size_t first, std::size_t other) {
        return items[other].area_mm2 >= (1 - kSameArea) * items[first].area_mm2;
      },
      [&](std::span<std::size_t> run) {
        sort_by_place(items, 2, kSamePlace * circle_radius(items[run.front()].area_mm2), run);
      });
  return order;
}

}  // namespace lumesh
