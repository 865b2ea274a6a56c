#pragma once
/// @file Medians and percentiles of numbers.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace lumesh {

/// The value that `rank` of the others come before, by size; equal ones in any order.
/// @param rank  Below values.size(). Linear cost.
[[nodiscard]] inline double value_of_rank(std::vector<double> values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace lumesh
