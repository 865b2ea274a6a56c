#pragma once
/// @file Sweeps of operators over a mesh on many threads, with the same result, bit for bit, on any number of
/// them.
///
/// Vertices are partitioned into buckets (partition.hpp); a sweep runs the buckets in a fixed partial order,
/// so that whoever meets has met in that order on every machine. Numbers of new elements depend on which
/// thread made them; nothing else does, because no order is ever taken from them: the elements have a
/// sequence of their own, the old ones first and then what each bucket made, by bucket.

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
  /// Cuts into buckets anew, if anything was run since.
  void repartition();

  /// Calls step(kernel, tet) for every live tetrahedron whose urgency before the sweep is positive and that
  /// is still as it was when its turn comes. All its vertices are held then. Within a bucket the most urgent
  /// come first, equal ones in the order of the sequence.
  void over_tets(const std::function<double(TetId)>& urgency,
                 const std::function<void(Kernel&, TetId)>& step);
  /// The same over vertices, which are held one by one; the step may free them.
  void over_urgent_vertices(const std::function<double(VertexId)>& urgency,
                            const std::function<void(Kernel&, VertexId)>& step);
  /// Calls step(kernel, vertex) for every live vertex. The step must not add or free elements.
  void over_vertices(const std::function<void(Kernel&, VertexId)>& step);

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
  template <class Urgency, class BucketOf, class Step>
  void over_urgent(const std::vector<std::uint32_t>& items, const Urgency& urgency, const BucketOf& bucket_of,
                   const Step& step);
  void run_buckets(const std::function<void(Kernel&, std::uint32_t bucket, std::uint32_t run)>& body);
  void begin_run(Kernel& kernel, std::uint32_t bucket, std::uint32_t run);
  [[nodiscard]] Made what_was_made(const Kernel& kernel, std::uint32_t run);
  void append_made(const std::vector<Made>& made);

  Subject subject_;
  parallel::Team team_;
  std::vector<Kernel> kernels_;  // One per thread.
  std::function<bool()> is_told_to_stop_ = [] { return false; };
  Partition partition_;
  bool is_cut_ = false;              // Nothing was run since.
  parallel::TaskOrder order_;        // Of the buckets.
  std::vector<std::uint32_t> runs_;  // Of each bucket: the run whose reach it lies in.
  std::uint32_t epoch_ = 0;          // Of the sweep; goes on when the mesh is reordered.
  std::uint32_t next_run_ = 1;       // Stamps are twice the run, plus 1 once listed; see what_was_made().
  std::vector<std::uint32_t> tets_, vertices_;  // The sequences.
};

}  // namespace lumesh::operators
