#pragma once
/// @file Sweeps of operators over a mesh on many threads, bitwise identical for every thread count.
///
/// Vertices are partitioned into buckets (partition.hpp); a sweep runs the buckets in a fixed partial order,
/// so that buckets in conflict run in that order on every machine. Numbers of new elements depend on the
/// thread that made them; nothing else does, because no order is ever taken from them: the elements have a
/// sequence of their own, the old ones first and then those that each bucket made, by bucket.

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/operators/operators.hpp"
#include "lumesh/operators/partition.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::operators {

class OrderedExecution {
 public:
  using Kernel = Operators<OrderedLock>;
  /// The mesh must have metrics. It is reordered.
  OrderedExecution(const Subject& subject, const parallel::TeamOptions& team);

  /// Orders the mesh along the curve and cuts it into buckets anew. Needed when it has grown much, for
  /// locality and because buckets grow with it.
  void reorder();
  /// Cuts the mesh into buckets anew, if anything was run since.
  void repartition();

  /// Calls step(kernel, tet) for every live tetrahedron whose priority before the sweep is positive and that
  /// is still as it was when its turn comes. All its vertices are held then. Within a bucket those of the
  /// highest priority come first, equal ones in the order of the sequence.
  void for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                const std::function<void(Kernel&, TetId)>& step);
  /// As for_each_tet_by_priority(), over vertices, which are held one by one; the step may free them.
  void for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                   const std::function<void(Kernel&, VertexId)>& step);
  /// Calls step(kernel, vertex) for every live vertex. The step must not add or free elements.
  void for_each_vertex(const std::function<void(Kernel&, VertexId)>& step);

  /// Has sweeps leave out all that is left once `is_told` says so, which is asked before each step, on any
  /// thread. The mesh stays valid; which steps were made is a matter of chance then.
  void stop_by(std::function<bool()> is_told) { is_told_to_stop_ = std::move(is_told); }

  [[nodiscard]] ExecutionCounts counts() const;

 private:
  /// Items of each bucket, in the order of the sequence.
  template <class Item>
  struct Lists {
    std::vector<std::uint32_t> starts;
    std::vector<Item> items;

    [[nodiscard]] std::span<Item> of(std::uint32_t bucket) {
      return std::span(items).subspan(starts[bucket], starts[bucket + 1] - starts[bucket]);
    }
  };
  struct Made {
    std::vector<std::uint32_t> tets, vertices;
  };

  template <class Item, class BucketOf>
  [[nodiscard]] Lists<Item> lists_by_bucket(const std::vector<Item>& items, const BucketOf& bucket_of) const;
  template <class Priority, class BucketOf, class Step>
  void for_each_by_priority(const std::vector<std::uint32_t>& items, const Priority& priority,
                            const BucketOf& bucket_of, const Step& step);
  void run_buckets(const std::function<void(Kernel&, std::uint32_t bucket, std::uint32_t run)>& body);
  void begin_run(Kernel& kernel, std::uint32_t bucket, std::uint32_t run);
  [[nodiscard]] Made what_was_made(const Kernel& kernel, std::uint32_t run);
  void append_made(const std::vector<Made>& made);

  Subject subject_;
  parallel::Team team_;
  std::vector<Kernel> kernels_;  // One per thread.
  std::function<bool()> is_told_to_stop_ = [] { return false; };
  Partition partition_;
  bool is_cut_ = false;              // Whether nothing was run since the partition.
  parallel::TaskOrder order_;        // Order of the buckets.
  std::vector<std::uint32_t> runs_;  // For each bucket, the run whose reach it lies in.
  std::uint32_t epoch_ = 0;          // Epoch of the sweep; goes on when the mesh is reordered.
  std::uint32_t next_run_ = 1;       // Stamps are twice the run, plus 1 once listed; see what_was_made().
  std::vector<std::uint32_t> tets_, vertices_;  // The sequences.
};

}  // namespace lumesh::operators
