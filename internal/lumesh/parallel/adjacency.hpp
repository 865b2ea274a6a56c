#pragma once
/// @file Lists of items, one for each of some owners, such as the tetrahedra around each vertex.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/uninitialised.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {

/// Items of owner i are items[starts[i]] to items[starts[i + 1]].
template <class Item>
struct Lists {
  std::vector<std::uint32_t> starts = {0};
  UninitialisedVector<Item> items;

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(starts.size() - 1); }
  [[nodiscard]] std::span<const Item> of(std::size_t owner) const {
    return {items.data() + starts[owner], starts[owner + 1] - starts[owner]};
  }
  [[nodiscard]] std::span<Item> of(std::size_t owner) {
    return {items.data() + starts[owner], starts[owner + 1] - starts[owner]};
  }
};

using Adjacency = Lists<std::uint32_t>;

/// Groups items 0, 1, ... by their owners: owners_of(item) is a range of numbers below `owners`. Blocks of
/// items hand themselves to ranges of owners, each range then fills its own part; blocks are visited in
/// order, so every list ascends. Linear cost, parallel inside, the same for every thread count.
template <class OwnersOf>
[[nodiscard]] Adjacency group_by_owner(std::size_t item_count, std::size_t owners,
                                       const OwnersOf& owners_of) {
  constexpr std::size_t kBlock = 32768;  // items
  constexpr std::size_t kRanges = 64;
  struct Pair {
    std::uint32_t owner, item;
  };
  const std::size_t range = owners / kRanges + 1;
  std::vector<std::array<std::vector<Pair>, kRanges>> handed((item_count + kBlock - 1) / kBlock);
  for_each_block(item_count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (const std::uint32_t owner : owners_of(i))
        handed[b][owner / range].push_back({owner, static_cast<std::uint32_t>(i)});
  });
  std::array<std::uint32_t, kRanges + 1> first{};
  for (std::size_t r = 0; r < kRanges; ++r) {
    first[r + 1] = first[r];
    for (const auto& block : handed) first[r + 1] += static_cast<std::uint32_t>(block[r].size());
  }
  Adjacency lists;
  lists.starts.resize(owners + 1);
  lists.starts.back() = first[kRanges];
  lists.items.resize(first[kRanges]);
  for_each_index(kRanges, 1, [&](std::size_t r) {
    const std::size_t low = std::min(r * range, owners), high = std::min(low + range, owners);
    std::vector<std::uint32_t> place(high - low, 0);  // First the counts, then where the next one goes.
    for (const auto& block : handed)
      for (const Pair& pair : block[r]) ++place[pair.owner - low];
    std::uint32_t next = first[r];
    for (std::size_t o = low; o < high; ++o) {
      lists.starts[o] = next;
      next += std::exchange(place[o - low], next);
    }
    for (const auto& block : handed)
      for (const Pair& pair : block[r]) lists.items[place[pair.owner - low]++] = pair.item;
  });
  return lists;
}

/// The cells around each vertex. @param cells  Ranges of vertices below `vertices`.
template <class Cells>
[[nodiscard]] Adjacency cells_around(const Cells& cells, std::size_t vertices) {
  return group_by_owner(
      cells.size(), vertices, [&](std::size_t c) -> const auto& { return cells[c]; });
}

/// Items that list(owner, items) appends for each owner. Owners are served in parallel, `block` by one thread
/// at a time; the starts are right if there are less than 2^32 items.
template <class Item = std::uint32_t, class List>
[[nodiscard]] Lists<Item> collect_lists(std::size_t owners, std::size_t block, const List& list) {
  Lists<Item> lists;
  lists.starts.resize(owners + 1);
  collect_blocks_into(lists.items, owners, block,
                      [&](std::size_t begin, std::size_t end, std::vector<Item>& out) {
                        for (std::size_t owner = begin; owner < end; ++owner) {
                          const std::size_t before = out.size();
                          list(owner, out);
                          lists.starts[owner + 1] = static_cast<std::uint32_t>(out.size() - before);
                        }
                      });
  for (std::size_t owner = 0; owner < owners; ++owner) lists.starts[owner + 1] += lists.starts[owner];
  return lists;
}

template <class List>
[[nodiscard]] Adjacency collect_lists(std::size_t owners, const List& list) {
  return collect_lists(owners, 4096, list);
}

/// Adds that a and b are neighbours to pairs for adjacency_of().
inline void add_both_ways(std::uint64_t a, std::uint64_t b, std::vector<std::uint64_t>& pairs) {
  pairs.push_back(a << 32 | b);
  pairs.push_back(b << 32 | a);
}

/// Ascending lists from pairs owner << 32 | item, in any order; doubles count once. Linear cost, parallel
/// inside.
[[nodiscard]] Adjacency adjacency_of(std::span<const std::uint64_t> pairs, std::size_t owners);

}  // namespace lumesh::parallel
