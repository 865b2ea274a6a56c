#pragma once
/// @file Vertices around a vertex.

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::metric {

/// Vertices within `rings` edges of v or more, until there are `wanted`, without v; v's own neighbours first.
[[nodiscard]] inline std::vector<std::uint32_t> vertices_about(const parallel::Adjacency& neighbours,
                                                               std::size_t v, int rings, std::size_t wanted) {
  constexpr int kMaxRings = 4;
  std::vector<std::uint32_t> found = {static_cast<std::uint32_t>(v)}, ring;
  std::size_t reached = 0;  // Those before it have been looked at.
  for (int r = 0; r < kMaxRings && (r < rings || found.size() <= wanted); ++r) {
    ring.clear();
    for (; reached < found.size(); ++reached)
      for (const std::uint32_t w : neighbours.of(found[reached])) ring.push_back(w);
    sort_unique(ring);
    std::vector<std::uint32_t> before(found);
    std::ranges::sort(before);
    std::set_difference(ring.begin(), ring.end(), before.begin(), before.end(), std::back_inserter(found));
  }
  found.erase(found.begin());
  return found;
}

}  // namespace lumesh::metric
