#include "lumesh/operators/ordered_execution.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "execution_parts.hpp"
#include "lumesh/core/assert.hpp"

namespace lumesh::operators {
namespace {

constexpr std::uint32_t kLastRun = 1u << 30;  // Stamps are twice as large and stay below the dead one.

std::vector<std::uint32_t> numbers_up_to(std::uint32_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

/// The old items that no run of this sweep freed or made anew, in their order.
template <class Stamp>
std::vector<std::uint32_t> untouched(const std::vector<std::uint32_t>& items, std::uint32_t first_stamp,
                                     const Stamp& stamp_of) {
  return parallel::collect_blocks<std::uint32_t>(
      items.size(), kItemBlock, [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out) {
        for (std::size_t i = begin; i < end; ++i)
          if (stamp_of(items[i]) < first_stamp) out.push_back(items[i]);
      });
}

}  // namespace

OrderedExecution::OrderedExecution(const Subject& subject, const parallel::TeamOptions& team)
    : KernelTeam(subject, team) {
  reorder();
}

void OrderedExecution::reorder() {
  TetMesh& mesh = subject_.mesh;
  mesh.reorder_along_curve();
  mesh.set_owners(team_.size(), kSlotBlock);
  next_run_ = 1;
  tets_ = numbers_up_to(mesh.tet_count());
  vertices_ = numbers_up_to(mesh.vertex_count());
  is_cut_ = false;
  repartition();
}

void OrderedExecution::repartition() {
  if (is_cut_) return;
  is_cut_ = true;
  partition_ = partition_vertices(subject_.mesh, vertices_, tets_,
                                  static_cast<std::uint32_t>(bucket_size_for(vertices_.size())));
  order_ = parallel::order_of(partition_.conflicts);
  runs_.assign(partition_.buckets, 0);
}

template <class Item, class BucketOf>
parallel::Lists<Item> OrderedExecution::lists_by_bucket(const std::vector<Item>& items,
                                                        const BucketOf& bucket_of) const {
  parallel::Adjacency numbers = parallel::group_by_owner(
      items.size(), partition_.buckets, [&](std::size_t i) { return std::array{bucket_of(items[i])}; });
  parallel::Lists<Item> lists{std::move(numbers.starts), UninitialisedVector<Item>(items.size())};
  parallel::for_each_index(items.size(), [&](std::size_t i) { lists.items[i] = items[numbers.items[i]]; });
  return lists;
}

void OrderedExecution::begin_run(Kernel& kernel, std::uint32_t bucket, std::uint32_t run) {
  // Relaxed: buckets of this reach belong to no other running one; the order of runs makes them visible.
  parallel::store_relaxed(runs_[bucket], run);
  for (const std::uint32_t next : partition_.neighbours.of(bucket)) parallel::store_relaxed(runs_[next], run);
  kernel.begin_run(OrderedLock(subject_.mesh, runs_.data(), run, bucket), 2 * run, epoch_);
}

template <class Item, class Step>
std::vector<OrderedExecution::Made> OrderedExecution::run_buckets(const parallel::Lists<Item>& lists,
                                                                  const Step& step) {
  ++epoch_;
  is_cut_ = false;
  const std::uint32_t first = next_run_;
  next_run_ += partition_.buckets;
  LUMESH_ASSERT(next_run_ < kLastRun);
  std::vector<Made> made(partition_.buckets);
  parallel::run_ordered(team_, partition_.conflicts, order_, [&](std::uint32_t bucket, int thread) {
    Kernel& kernel = kernels_[static_cast<std::size_t>(thread)];
    begin_run(kernel, bucket, first + bucket);
    for (const Item& item : lists.of(bucket)) {
      if (is_told_to_stop_()) break;
      step(kernel, item);
    }
    made[bucket] = what_was_made(kernel, first + bucket);
  });
  return made;
}

template <class Priority, class BucketOf, class Step>
void OrderedExecution::for_each_by_priority(const std::vector<std::uint32_t>& items, const Priority& priority,
                                            const BucketOf& bucket_of, const Step& step) {
  const auto picked = parallel::collect_blocks<PrioritisedItem>(
      items.size(), kItemBlock, [&](std::size_t begin, std::size_t end, std::vector<PrioritisedItem>& out) {
        for (std::size_t i = begin; i < end; ++i)
          if (const auto value = static_cast<float>(priority(items[i])); value > 0)
            out.push_back({items[i], value});
      });
  if (picked.empty()) return;
  auto lists = lists_by_bucket(picked, [&](const PrioritisedItem& one) { return bucket_of(one.item); });
  parallel::for_each_index(partition_.buckets, 1, [&](std::size_t bucket) {
    std::ranges::stable_sort(lists.of(bucket), has_higher_priority);
  });
  const std::uint32_t first_stamp = 2 * next_run_;
  const std::vector<Made> made = run_buckets(
      lists, [&](Kernel& kernel, const PrioritisedItem& one) { step(kernel, one.item, first_stamp); });
  const TetMesh& mesh = subject_.mesh;
  tets_ = untouched(tets_, first_stamp, [&](std::uint32_t t) { return mesh.stamp(TetId(t)); });
  vertices_ = untouched(vertices_, first_stamp, [&](std::uint32_t v) { return mesh.stamp(VertexId(v)); });
  append_made(made);
}

void OrderedExecution::for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                                const std::function<void(Kernel&, TetId)>& step) {
  TetMesh& mesh = subject_.mesh;
  for_each_by_priority(
      tets_, [&](std::uint32_t t) { return priority(TetId(t)); },
      [&](std::uint32_t t) { return mesh.lock_word(mesh.vertex(TetId(t), 0)); },
      [&](Kernel& kernel, std::uint32_t item, std::uint32_t first_stamp) {
        // An old stamp says that t is what it was, so that its first vertex is one of this bucket.
        const TetId t(item);
        if (mesh.stamp(t) < first_stamp && kernel.try_lock(t)) step(kernel, t);
      });
}

void OrderedExecution::for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                                   const std::function<void(Kernel&, VertexId)>& step) {
  TetMesh& mesh = subject_.mesh;
  for_each_by_priority(
      vertices_, [&](std::uint32_t v) { return priority(VertexId(v)); },
      [&](std::uint32_t v) { return mesh.lock_word(VertexId(v)); },
      [&](Kernel& kernel, std::uint32_t item, std::uint32_t first_stamp) {
        const VertexId v(item);
        if (mesh.stamp(v) < first_stamp) step(kernel, v);  // Else it is gone, and maybe another one.
      });
}

void OrderedExecution::for_each_vertex(const std::function<void(Kernel&, VertexId)>& step) {
  const parallel::Adjacency lists =
      lists_by_bucket(vertices_, [&](std::uint32_t v) { return subject_.mesh.lock_word(VertexId(v)); });
  run_buckets(lists, [&](Kernel& kernel, std::uint32_t v) { step(kernel, VertexId(v)); });
}

/// Live ones, each once: the stamp of what is listed becomes odd.
OrderedExecution::Made OrderedExecution::what_was_made(const Kernel& kernel, std::uint32_t run) {
  Made made;
  const auto take = [&](auto id, std::vector<std::uint32_t>& out) {
    if (subject_.mesh.stamp(id) != 2 * run) return;
    subject_.mesh.set_stamp(id, 2 * run + 1);
    out.push_back(id.value);
  };
  for (const TetId t : kernel.made_tets()) take(t, made.tets);
  for (const VertexId v : kernel.made_vertices()) take(v, made.vertices);
  return made;
}

/// By bucket; what a later run freed or made anew has another stamp.
void OrderedExecution::append_made(const std::vector<Made>& made) {
  constexpr std::size_t kBucketBlock = 16;
  const TetMesh& mesh = subject_.mesh;
  const std::uint32_t first_run = next_run_ - partition_.buckets;
  const auto append = [&](std::vector<std::uint32_t>& items, std::vector<std::uint32_t> Made::*of,
                          const auto& stamp_of) {
    const auto more = parallel::collect<std::uint32_t>(
        made.size(), kBucketBlock, [&](std::size_t bucket, std::vector<std::uint32_t>& out) {
          const std::uint32_t stamp = 2 * (first_run + static_cast<std::uint32_t>(bucket)) + 1;
          for (const std::uint32_t item : made[bucket].*of)
            if (stamp_of(item) == stamp) out.push_back(item);
        });
    items.insert(items.end(), more.begin(), more.end());
  };
  append(tets_, &Made::tets, [&](std::uint32_t t) { return mesh.stamp(TetId(t)); });
  append(vertices_, &Made::vertices, [&](std::uint32_t v) { return mesh.stamp(VertexId(v)); });
}

}  // namespace lumesh::operators
