#pragma once
// Which items belong to which owner, in parallel and in linear time.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/parallel/loops.hpp"

namespace lumesh {

/// For each owner the numbers of its items, ascending.
struct Groups {
  std::vector<std::uint32_t> begin;  ///< First place of each owner in `items`; one more at the end.
  std::vector<std::uint32_t> items;
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t owner) const {
    return {items.data() + begin[owner], begin[owner + 1] - begin[owner]};
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
  groups.begin.resize(owner_count + 1);
  groups.items.resize(first[kRanges]);
  parallel::for_each_index(
      kRanges,
      [&](std::size_t r) {
        const std::size_t low = std::min(r * range, owner_count);
        const std::size_t high = std::min(low + range, owner_count);
        std::vector<std::uint32_t> place(high - low + 1, 0);
        for (const auto& block : handed) {
          for (const Pair& pair : block[r]) ++place[pair.owner - low + 1];
        }
        place[0] = first[r];
        for (std::size_t o = 0; o < high - low; ++o) {
          place[o + 1] += place[o];
          groups.begin[low + o] = place[o];
        }
        for (const auto& block : handed) {
          for (const Pair& pair : block[r]) groups.items[place[pair.owner - low]++] = pair.item;
        }
      },
      1);
  groups.begin[owner_count] = first[kRanges];
  return groups;
}

}  // namespace lumesh
