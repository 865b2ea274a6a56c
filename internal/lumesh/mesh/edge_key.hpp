#pragma once
/// @file One number for the edge between two vertices.

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace lumesh {

/// Key of the edge between two vertices, whichever comes first: the lower one is in the upper half.
[[nodiscard]] inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

/// Calls visit(from, to) for each edge of a polygon, the way round that its corners are in.
template <class Corners, class Visit>
void for_each_edge_of(const Corners& corners, const Visit& visit) {
  for (std::size_t i = 0; i < corners.size(); ++i) visit(corners[i], corners[(i + 1) % corners.size()]);
}

}  // namespace lumesh
