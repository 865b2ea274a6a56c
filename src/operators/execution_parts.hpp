#pragma once
/// @file Buckets of executions.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"
#include "lumesh/parallel/team.hpp"
#include "lumesh/parallel/word_lock.hpp"

namespace lumesh::operators {

inline constexpr std::uint32_t kSlotBlock = 1024;  // Slots that a thread takes at a time.
inline constexpr std::size_t kItemBlock = 4096;    // Of parallel loops.

/// The number of an element and its priority in a sweep.
struct PrioritisedItem {
  std::uint32_t item;
  float priority;
};
[[nodiscard]] inline bool has_higher_priority(const PrioritisedItem& a, const PrioritisedItem& b) {
  return a.priority > b.priority;
}

/// Shares the slots of a mesh among threads; no vertex is held.
inline void share_slots(TetMesh& mesh, int threads) {
  mesh.set_owners(threads, kSlotBlock);
  parallel::for_each_index(mesh.vertex_slots(), [&](std::size_t v) {
    mesh.lock_word(VertexId(static_cast<std::uint32_t>(v))) = parallel::kFreeWord;
  });
}

/// Runs attempts at items in buckets of `size` on the threads of a team; what contends is tried again.
/// @param begin  begin(thread) gives the attempt(item) of one run of a bucket: false if it must be made
/// again.
template <class Item, class Begin>
void run_in_buckets(parallel::Team& team, std::vector<Item>& items, std::size_t size, const Begin& begin) {
  std::vector<std::span<Item>> left;  // Of each bucket.
  for (std::size_t first = 0; first < items.size(); first += size)
    left.push_back(std::span(items).subspan(first, std::min(size, items.size() - first)));
  parallel::run_freely(team, static_cast<std::uint32_t>(left.size()), [&](std::uint32_t bucket, int thread) {
    auto attempt = begin(static_cast<std::size_t>(thread));
    const std::span<Item> mine = left[bucket];
    parallel::Backoff backoff;
    std::size_t contended = 0;
    for (const Item& item : mine) {
      if (attempt(item)) {
        backoff.won();
      } else {
        mine[contended++] = item;
        backoff.lost();
      }
    }
    left[bucket] = mine.first(contended);
    if (contended == 0) return parallel::TaskEnd::kDone;
    return contended < mine.size() ? parallel::TaskEnd::kSomeLeft : parallel::TaskEnd::kNothingDone;
  });
}

}  // namespace lumesh::operators
