#pragma once
// Which items belong to which owner, in parallel and in linear time.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/uninitialised.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

/// For each owner the numbers of its items.
struct Groups {
  struct Range {
    std::uint32_t begin = 0, end = 0;
  };
  std::vector<Range> ranges;  ///< Range of each owner in `items`.
  UninitialisedVector<std::uint32_t> items;
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

/// Groups items 0, 1, ... by their owners: owners_of(item) is a range of owners below `owner_count`. Blocks
/// of items hand themselves to ranges of owners, each range then fills its own part; blocks are visited in
/// order, so every group ascends.
template <class OwnersOf>
[[nodiscard]] Groups group_by_owner(std::size_t item_count, std::size_t owner_count,
                                    const OwnersOf& owners_of) {
  constexpr std::size_t kBlock = 32768;  // items
  constexpr std::size_t kRanges = 64;
  struct Pair {
    std::uint32_t owner, item;
  };
  const std::size_t range = owner_count / kRanges + 1;
  std::vector<std::array<std::vector<Pair>, kRanges>> handed((item_count + kBlock - 1) / kBlock);
  parallel::for_each_block(item_count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t owner : owners_of(i))
        handed[b][owner / range].push_back({owner, static_cast<std::uint32_t>(i)});
    }
  });
  std::array<std::uint32_t, kRanges + 1> first{};
  for (std::size_t r = 0; r < kRanges; ++r) {
    first[r + 1] = first[r];
    for (const auto& block : handed) first[r + 1] += static_cast<std::uint32_t>(block[r].size());
  }
  Groups groups;
  groups.ranges.resize(owner_count);
  groups.items.resize(first[kRanges]);
  parallel::for_each_index(
      kRanges,
      [&](std::size_t r) {
        const std::size_t low = std::min(r * range, owner_count);
        const std::size_t high = std::min(low + range, owner_count);
        std::vector<std::uint32_t> place(high - low, 0);  // first the counts, then where the next one goes
        for (const auto& block : handed) {
          for (const Pair& pair : block[r]) ++place[pair.owner - low];
        }
        std::uint32_t next = first[r];
        for (std::size_t o = low; o < high; ++o) {
          const std::uint32_t count = std::exchange(place[o - low], next);
          next += count;
          groups.ranges[o] = {place[o - low], next};
        }
        for (const auto& block : handed) {
          for (const Pair& pair : block[r]) groups.items[place[pair.owner - low]++] = pair.item;
        }
      },
      1);
  return groups;
}

}  // namespace lumesh
