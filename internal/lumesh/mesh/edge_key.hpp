#pragma once
/// @file One number for the edge between two vertices.

#include <algorithm>
#include <cstdint>

namespace lumesh {

/// Key of the edge between two vertices, whichever comes first: the lower one is in the upper half.
[[nodiscard]] inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

}  // namespace lumesh
