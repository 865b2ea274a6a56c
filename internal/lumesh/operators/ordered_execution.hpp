#pragma once
/// @file Sweeps of operators over a mesh on many threads, bitwise identical for every thread count.
///
/// Vertices are partitioned into buckets (partition.hpp); a sweep runs the buckets in a fixed partial order,
/// so that buckets in conflict run in that order on every machine. Numbers of new elements depend on the
/// thread that made them; nothing else does, because no order is ever taken from them: the elements have a
/// sequence of their own, the old ones first and then those that each bucket made, by bucket.

#include <cstdint>
#include <functional>
#include <vector>

#include "lumesh/operators/execution.hpp"
#include "lumesh/operators/partition.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"

namespace lumesh::operators {

/// An Execution. Items of equal priority come in the order of the sequence.
class OrderedExecution : public KernelTeam<OrderedLock> {
 public:
  /// The mesh must have metrics. It is reordered.
  OrderedExecution(const Subject& subject, const parallel::TeamOptions& team);

  void reorder();
  void repartition();
  void for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                const std::function<void(Kernel&, TetId)>& step);
  void for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                   const std::function<void(Kernel&, VertexId)>& step);
  void for_each_vertex(const std::function<void(Kernel&, VertexId)>& step);

 private:
  struct Made {
    std::vector<std::uint32_t> tets, vertices;
  };

  /// Items of each bucket, in the order of the sequence.
  template <class Item, class BucketOf>
  [[nodiscard]] parallel::Lists<Item> lists_by_bucket(const std::vector<Item>& items,
                                                      const BucketOf& bucket_of) const;
  template <class Priority, class BucketOf, class Step>
  void for_each_by_priority(const std::vector<std::uint32_t>& items, const Priority& priority,
                            const BucketOf& bucket_of, const Step& step);
  /// The steps at all items of each bucket, step(kernel, item). @return what each bucket made.
  template <class Item, class Step>
  std::vector<Made> run_buckets(const parallel::Lists<Item>& lists, const Step& step);
  void begin_run(Kernel& kernel, std::uint32_t bucket, std::uint32_t run);
  [[nodiscard]] Made what_was_made(const Kernel& kernel, std::uint32_t run);
  void append_made(const std::vector<Made>& made);

  Partition partition_;
  bool is_cut_ = false;              // Whether nothing was run since the partition.
  parallel::TaskOrder order_;        // Order of the buckets.
  std::vector<std::uint32_t> runs_;  // For each bucket, the run whose reach it lies in.
  std::uint32_t next_run_ = 1;       // Stamps are twice the run, plus 1 once listed; see what_was_made().
  std::vector<std::uint32_t> tets_, vertices_;  // The sequences.
};

}  // namespace lumesh::operators
