#pragma once
/// @file Data-parallel loops. Results never depend on the number of threads: blocks have fixed borders, and
/// reductions combine them in a fixed order. Within run_cancellable() every loop ends in Cancelled once that
/// is told to stop: blocks that have begun are finished, no other begins. oneTBB is used in this module and
/// nowhere else.

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_scan.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/core/uninitialised.hpp"
#include "lumesh/parallel/cancellation.hpp"

namespace lumesh::parallel {

/// Limits every loop below to `threads` threads while the object lives; 0 means all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads)
      : control_(tbb::global_control::max_allowed_parallelism,
                 threads > 0 ? static_cast<std::size_t>(threads)
                             : static_cast<std::size_t>(tbb::info::default_concurrency())) {}

 private:
  tbb::global_control control_;
};

/// Calls body(i) for every i in [0, count); `grain` is the least number of indices per task.
template <class Body>
void for_each_index(std::size_t count, std::size_t grain, const Body& body) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t>& range) {
        // A task may have far more indices than `grain`. Looking up takes as long as some ten of the
        // cheapest bodies: between grains of few, which are costly, else between eight.
        const std::size_t step = range.grainsize() < 256 ? range.grainsize() : 8 * range.grainsize();
        for (std::size_t i = range.begin(); i < range.end() && !is_cancelled();) {
          const std::size_t next = std::min(range.end(), i + step);
          for (; i != next; ++i) body(i);
        }
      });
  check_cancelled();
}
template <class Body>
void for_each_index(std::size_t count, const Body& body) {
  for_each_index(count, 1024, body);
}

/// Splits [0, count) into blocks of `block` indices and calls body(block_index, begin, end) for each.
template <class Body>
void for_each_block(std::size_t count, std::size_t block, const Body& body) {
  const std::size_t blocks = (count + block - 1) / block;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, blocks, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t b = range.begin(); b != range.end() && !is_cancelled(); ++b)
          body(b, b * block, std::min(count, (b + 1) * block));
      },
      tbb::simple_partitioner());
  check_cancelled();
}

/// Reduces map(begin, end) over fixed blocks with `combine`, in block order: bitwise identical for every
/// thread count.
template <class Value, class Map, class Combine>
[[nodiscard]] Value reduce_blocks(std::size_t count, std::size_t block, Value identity, const Map& map,
                                  const Combine& combine) {
  std::vector<Value> partial((count + block - 1) / block, identity);
  for_each_block(count, block,
                 [&](std::size_t b, std::size_t begin, std::size_t end) { partial[b] = map(begin, end); });
  Value total = std::move(identity);
  for (Value& value : partial) total = combine(std::move(total), std::move(value));
  return total;
}

/// Sorts with a total order: equal elements must be indistinguishable, or the result depends on the schedule.
template <class Iterator, class Less = std::less<>>
void sort(Iterator begin, Iterator end, Less less = {}) {
  tbb::parallel_sort(begin, end, less);
  check_cancelled();
}

/// Sorts and drops repeats, as lumesh::sort_unique().
template <class Items, class... Less>
void sort_unique(Items& items, const Less&... less) {
  parallel::sort(items.begin(), items.end(), less...);
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

/// Runs both functions, possibly at the same time.
template <class First, class Second>
void invoke_both(First&& first, Second&& second) {
  tbb::parallel_for(0, 2, [&](int i) { i == 0 ? first() : second(); });
  check_cancelled();
}

/// Sets a flag that several threads may set in the same loop; nobody may read it before the loop ends.
/// Test: Raise.MarksWhatAnyBodyMarks.
inline void raise(std::uint8_t& flag) {
  std::atomic_ref(flag).store(1, std::memory_order_relaxed);
}

/// Items that append(begin, end, out) appends for each fixed block of [0, count).
template <class Item, class Append>
[[nodiscard]] std::vector<std::vector<Item>> collect_parts(std::size_t count, std::size_t block,
                                                           const Append& append) {
  std::vector<std::vector<Item>> parts((count + block - 1) / block);
  for_each_block(count, block,
                 [&](std::size_t b, std::size_t begin, std::size_t end) { append(begin, end, parts[b]); });
  return parts;
}

/// Collects what append(begin, end, out) appends for fixed blocks of [0, count), in block order whatever the
/// thread count.
template <class Item, class Append>
[[nodiscard]] std::vector<Item> collect_blocks(std::size_t count, std::size_t block, const Append& append) {
  const std::vector<std::vector<Item>> parts = collect_parts<Item>(count, block, append);
  std::size_t total = 0;
  for (const auto& part : parts) total += part.size();
  std::vector<Item> all;
  all.reserve(total);
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// The same for results so large that all threads copy them, to the end of a vector; new memory is touched
/// first by the threads that copy.
template <class Item, class Append>
void collect_blocks_into(UninitialisedVector<Item>& all, std::size_t count, std::size_t block,
                         const Append& append) {
  std::vector<std::vector<Item>> parts = collect_parts<Item>(count, block, append);
  std::vector<std::size_t> first = {all.size()};
  for (const auto& part : parts) first.push_back(first.back() + part.size());
  all.resize(first.back());
  for_each_index(parts.size(), 1, [&](std::size_t b) {
    const std::vector<Item> part = std::move(parts[b]);  // frees its memory at once
    std::copy(part.begin(), part.end(), all.begin() + static_cast<std::ptrdiff_t>(first[b]));
  });
}

/// Collects what append(i, out) appends for every i, in index order whatever the thread count.
template <class Item, class Append>
[[nodiscard]] std::vector<Item> collect(std::size_t count, std::size_t block, const Append& append) {
  return collect_blocks<Item>(count, block, [&](std::size_t begin, std::size_t end, std::vector<Item>& out) {
    for (std::size_t i = begin; i < end; ++i) append(i, out);
  });
}
template <class Item, class Append>
[[nodiscard]] std::vector<Item> collect(std::size_t count, const Append& append) {
  return collect<Item>(count, 4096, append);
}

}  // namespace lumesh::parallel
