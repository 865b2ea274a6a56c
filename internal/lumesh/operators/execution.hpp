#pragma once
/// @file Sweeps of operators over a mesh on many threads: what every execution offers, and what it stands on.

#include <concepts>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "lumesh/operators/kernel.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::operators {

/// OrderedExecution and SpeculativeExecution; passes are written once for both. Steps run on any thread, with
/// the kernel of that thread. Those of the highest priority come first, within a bucket.
template <class T>
concept Execution = requires(T& execution, const std::function<double(TetId)>& priority_of_tet,
                             const std::function<double(VertexId)>& priority_of_vertex,
                             const std::function<void(typename T::Kernel&, TetId)>& step_at_tet,
                             const std::function<void(typename T::Kernel&, VertexId)>& step_at_vertex) {
  // Orders the mesh along the curve. Needed when it has grown much, for locality and because buckets grow
  // with it.
  execution.reorder();
  // Cuts the mesh into buckets anew, if anything was run since.
  execution.repartition();
  // Takes the step at every live tetrahedron whose priority before the sweep is positive and that is still as
  // it was when its turn comes. All its vertices are held then.
  execution.for_each_tet_by_priority(priority_of_tet, step_at_tet);
  // The same over vertices, which are held one by one; the step may free them.
  execution.for_each_vertex_by_priority(priority_of_vertex, step_at_vertex);
  // Takes the step at every live vertex. It must not add or free elements.
  execution.for_each_vertex(step_at_vertex);
  // Has sweeps leave out all that is left once they are told so, which is asked before each step, on any
  // thread. The mesh stays valid; which steps were made is a matter of chance then.
  execution.stop_by(std::function<bool()>());
  { execution.counts() } -> std::same_as<ExecutionCounts>;
};

/// A team of threads with a kernel each.
template <class Lock>
class KernelTeam {
 public:
  using Kernel = operators::Kernel<Lock>;

  void stop_by(std::function<bool()> is_told) { is_told_to_stop_ = std::move(is_told); }
  [[nodiscard]] ExecutionCounts counts() const;

 protected:
  /// The mesh must have metrics. Trials of an earlier execution are forgotten.
  KernelTeam(const Subject& subject, const parallel::TeamOptions& team);

  Subject subject_;
  parallel::Team team_;
  std::vector<Kernel> kernels_;  // One per thread.
  std::function<bool()> is_told_to_stop_ = [] { return false; };
  std::uint32_t epoch_ = 0;  // Epoch of the sweep; goes on when the mesh is reordered.
};

}  // namespace lumesh::operators
