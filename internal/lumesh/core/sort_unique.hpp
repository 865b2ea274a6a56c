#pragma once
/// @file Lists of which each item is wanted once.

#include <algorithm>

namespace lumesh {

/// Ascending, or by `less`, and each item once. Equal ones must be neighbours in that order.
template <class Items, class... Less>
void sort_unique(Items& items, const Less&... less) {
  std::ranges::sort(items, less...);
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

}  // namespace lumesh
