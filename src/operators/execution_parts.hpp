#pragma once
/// @file Parts of both executions.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/operators/operators.hpp"
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

template <class Lock>
[[nodiscard]] std::vector<Operators<Lock>> kernels_for(const Subject& subject, const parallel::Team& team) {
  std::vector<Operators<Lock>> kernels;
  for (int thread = 0; thread < team.size(); ++thread) kernels.emplace_back(subject, Lock(), thread);
  return kernels;
}

/// Epochs begin anew; those of an earlier execution on this mesh would say that nothing has changed.
inline void forget_trials(TetMesh& mesh) {
  parallel::for_each_index(mesh.vertex_slots(), [&](std::size_t v) {
    mesh.set_change_epoch(VertexId(static_cast<std::uint32_t>(v)), 0);
  });
  parallel::for_each_index(mesh.tet_slots(), [&](std::size_t t) {
    mesh.set_trial_epoch(TetId(static_cast<std::uint32_t>(t)), 0);
  });
}

template <class Lock>
[[nodiscard]] ExecutionCounts counts_of(const std::vector<Operators<Lock>>& kernels,
                                        const parallel::Team& team) {
  ExecutionCounts counts;
  for (const Operators<Lock>& kernel : kernels) counts.by_thread.push_back(kernel.counts());
  counts.migrations = team.migrations();
  return counts;
}

}  // namespace lumesh::operators
