#pragma once
/// @file Sweeps of operators over a mesh on many threads that lock the vertices they touch as they go, and
/// back off where another was first (the paper's model). Which of two neighbours is changed first is left to
/// chance: the meshes of two runs differ, alike in quality.
///
/// The items of a sweep are cut into buckets, intervals of their numbers, which follow the Hilbert curve.
/// An item that contends goes to the back; a thread that gets nothing done is parked until others have
/// finished something, but the last active one never waits. Source: Tsolakis, Drakopoulos and Chrisochoides
/// 2018, Parallel metric-based anisotropic mesh adaptation using speculative execution on shared memory.

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "lumesh/operators/operators.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::operators {

/// Has the members of OrderedExecution.
class SpeculativeExecution {
 public:
  using Kernel = Operators<SpeculativeLock>;
  /// The mesh must have metrics. It is reordered.
  SpeculativeExecution(const Subject& subject, const parallel::TeamOptions& team);

  /// Orders the mesh along the curve.
  void reorder();
  /// Nothing: every sweep has its own buckets.
  void repartition() {}

  /// Calls step(kernel, tet) for every live tetrahedron whose priority before the sweep is positive and that
  /// is still as it was when its turn comes, again and again as long as operators only contend. All its
  /// vertices are held then. Within a bucket those of the highest priority come first.
  void for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                const std::function<void(Kernel&, TetId)>& step);
  /// As for_each_tet_by_priority(), over vertices, which are held one by one; the step may free them.
  void for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                   const std::function<void(Kernel&, VertexId)>& step);
  /// Calls step(kernel, vertex) for every live vertex, again and again as long as it only contends. The step
  /// must not add or free elements.
  void for_each_vertex(const std::function<void(Kernel&, VertexId)>& step);

  /// Has sweeps leave out all that is left once `is_told` says so, which is asked before each step, on any
  /// thread. The mesh stays valid; which steps were made is a matter of chance then.
  void stop_by(std::function<bool()> is_told) { is_told_to_stop_ = std::move(is_told); }

  [[nodiscard]] ExecutionCounts counts() const;

 private:
  /// @param attempt  attempt(kernel, item): false if it must be made again.
  template <class Item, class Attempt>
  void run_buckets(std::vector<Item>& items, const Attempt& attempt);

  template <class Id, class Priority, class Step>
  void for_each_by_priority(std::size_t slots, const Priority& priority, const Step& step);

  Subject subject_;
  parallel::Team team_;
  std::vector<Kernel> kernels_;  // One per thread.
  std::function<bool()> is_told_to_stop_ = [] { return false; };
  std::uint32_t epoch_ = 0;  // Of the sweep; goes on when the mesh is reordered.
  std::uint32_t stamp_ = 0;  // Of what the sweep makes; all earlier ones are lower.
};

}  // namespace lumesh::operators
