#pragma once
/// @file Places of grids: their numbers, the first index fastest, and loops over boxes of them.

#include <array>
#include <cstddef>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Rows along the first index, numbered as places.
[[nodiscard]] inline std::size_t grid_row_count(const Index3& size) {
  return static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
}
/// The first place of a row.
[[nodiscard]] inline Index3 grid_row(const Index3& size, std::size_t row) {
  const auto y = static_cast<std::size_t>(size.y());
  return {0, static_cast<int>(row % y), static_cast<int>(row / y)};
}

/// Calls visit(place, next, axis) for the numbers of two places next to each other along an axis, the first
/// of them in a row.
template <class Visit>
void for_each_step_from_row(const Index3& size, std::size_t row, const Visit& visit) {
  const auto x = static_cast<std::size_t>(size.x()), y = static_cast<std::size_t>(size.y());
  const std::array<std::size_t, 3> steps = {1, x, x * y};
  const std::array<std::size_t, 3> counts = {x - 1, row % y + 1 < y ? x : 0,
                                             row + y < grid_row_count(size) ? x : 0};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = row * x; i < row * x + counts[axis]; ++i) visit(i, i + steps[axis], axis);
}

/// The number of a place within its brick, of bricks of edge^3 places from the grid's first one on.
[[nodiscard]] inline std::size_t offset_in_brick(const Index3& place, int edge) {
  const auto within = [edge](int x) { return static_cast<std::size_t>(x % edge); };
  const auto n = static_cast<std::size_t>(edge);
  return within(place.x()) + n * (within(place.y()) + n * within(place.z()));
}

/// Places of a grid, both corners included.
struct IndexBox {
  Index3 low, high;

  [[nodiscard]] bool meets(const IndexBox& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
  [[nodiscard]] bool holds(const IndexBox& other) const {
    return (low.array() <= other.low.array()).all() && (other.high.array() <= high.array()).all();
  }
};

/// True if has(place) is true for a place of a box, `high` included, in the order of their numbers; the first
/// one ends the search.
template <class Has>
[[nodiscard]] bool is_any_place(const Index3& low, const Index3& high, const Has& has) {
  for (int k = low.z(); k <= high.z(); ++k)
    for (int j = low.y(); j <= high.y(); ++j)
      for (int i = low.x(); i <= high.x(); ++i)
        if (has(Index3(i, j, k))) return true;
  return false;
}

/// Calls visit(place) for the places of a box, `high` included, in the order of their numbers.
template <class Visit>
void for_each_place(const Index3& low, const Index3& high, const Visit& visit) {
  std::ignore = is_any_place(low, high, [&](const Index3& place) { return visit(place), false; });
}

}  // namespace lumesh
