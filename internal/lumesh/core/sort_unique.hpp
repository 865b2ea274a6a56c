#pragma once
/// @file Ascending lists, of which each item is wanted once.

#include <algorithm>
#include <cstdint>

namespace lumesh {

/// Ascending, or by `less`, and each item once. Equal ones must be neighbours in that order.
template <class Items, class... Less>
void sort_unique(Items& items, const Less&... less) {
  std::ranges::sort(items, less...);
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

/// How many items of an ascending list are less than a value: the number of the value in the list, if that
/// has it.
template <class Items, class Value>
[[nodiscard]] std::uint32_t rank_in(const Items& sorted, const Value& value) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(sorted, value) - sorted.begin());
}

}  // namespace lumesh
