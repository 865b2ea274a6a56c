#pragma once
// What of a triangle lies on one side of a plane.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::surfaces {

/// Calls add(corners) for each triangle of that part, which has three or four corners; four are divided by
/// the shorter diagonal.
/// @param sign  1 for what is above, -1 for what is below. @param heights, points  Those that crossing()
/// adds to. @param crossing  crossing(a, b) is the point of an edge in the plane.
template <class Crossing, class Add>
void for_each_in_part(const Cell<3>& corners, double sign, const std::vector<double>& heights,
                      const std::vector<Vec3>& points, const Crossing& crossing, const Add& add) {
  std::vector<std::uint32_t> part;
  for (std::size_t s = 0; s < 3; ++s) {
    const std::uint32_t a = corners[s], b = corners[(s + 1) % 3];
    if (sign * heights[a] >= 0) part.push_back(a);
    if (heights[a] * heights[b] < 0) part.push_back(crossing(a, b));
  }
  const auto length2 = [&](std::size_t a, std::size_t b) {
    return (points[part[a]] - points[part[b]]).squaredNorm();
  };
  if (part.size() == 4 && length2(1, 3) < length2(0, 2))
    std::rotate(part.begin(), part.begin() + 1, part.end());
  for (std::size_t i = 2; i < part.size(); ++i) add(Cell<3>{part[0], part[i - 1], part[i]});
}

}  // namespace lumesh::surfaces
