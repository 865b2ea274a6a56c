#pragma once
/// @file Lists of items of owners that may be exchanged one by one.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::fitting {

/// For each owner the numbers of its items.
struct Groups {
  struct Range {
    std::uint32_t begin = 0, end = 0;
  };
  std::vector<Range> ranges;  ///< Range of each owner in `items`.
  UninitialisedVector<std::uint32_t> items;

  Groups() = default;
  explicit Groups(parallel::Adjacency lists) : ranges(lists.size()), items(std::move(lists.items)) {
    for (std::size_t o = 0; o < ranges.size(); ++o) ranges[o] = {lists.starts[o], lists.starts[o + 1]};
  }
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t owner) const {
    const auto [begin, end] = ranges[owner];
    return {items.data() + begin, end - begin};
  }
  /// Gives an owner, perhaps a new one, other items; what it had stays in memory, unused.
  void replace(std::uint32_t owner, const std::vector<std::uint32_t>& others) {
    if (owner >= ranges.size()) ranges.resize(owner + std::size_t{1});
    ranges[owner].begin = static_cast<std::uint32_t>(items.size());
    items.insert(items.end(), others.begin(), others.end());
    ranges[owner].end = static_cast<std::uint32_t>(items.size());
  }
};

}  // namespace lumesh::fitting
