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
#include <vector>

#include "lumesh/operators/execution.hpp"

namespace lumesh::operators {

/// An Execution. A step is taken again and again as long as operators only contend.
class SpeculativeExecution : public KernelTeam<SpeculativeLock> {
 public:
  /// The mesh must have metrics. It is reordered.
  SpeculativeExecution(const Subject& subject, const parallel::TeamOptions& team);

  void reorder();
  /// Nothing: every sweep has its own buckets.
  void repartition() {}
  void for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                const std::function<void(Kernel&, TetId)>& step);
  void for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                   const std::function<void(Kernel&, VertexId)>& step);
  void for_each_vertex(const std::function<void(Kernel&, VertexId)>& step);

 private:
  /// @param attempt  attempt(kernel, item): false if it must be made again.
  template <class Item, class Attempt>
  void run_buckets(std::vector<Item>& items, const Attempt& attempt);

  template <class Id, class Priority, class Step>
  void for_each_by_priority(std::size_t slots, const Priority& priority, const Step& step);

  std::uint32_t stamp_ = 0;  // Of what the sweep makes; all earlier ones are lower.
};

}  // namespace lumesh::operators
