#include "lumesh/operators/execution.hpp"

#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {

template <class Lock>
KernelTeam<Lock>::KernelTeam(const Subject& subject, const parallel::TeamOptions& team)
    : subject_(subject), team_(team) {
  for (int thread = 0; thread < team_.size(); ++thread) kernels_.emplace_back(subject, Lock(), thread);
  // Epochs begin anew; those of an earlier execution on this mesh would say that nothing has changed.
  TetMesh& mesh = subject.mesh;
  parallel::for_each_index(mesh.vertex_slots(), [&](std::size_t v) {
    mesh.set_change_epoch(VertexId(static_cast<std::uint32_t>(v)), 0);
  });
  parallel::for_each_index(mesh.tet_slots(), [&](std::size_t t) {
    mesh.set_trial_epoch(TetId(static_cast<std::uint32_t>(t)), 0);
  });
}

template <class Lock>
ExecutionCounts KernelTeam<Lock>::counts() const {
  ExecutionCounts counts;
  for (const Kernel& kernel : kernels_) counts.by_thread.push_back(kernel.counts());
  counts.migrations = team_.migrations();
  return counts;
}

template class KernelTeam<OrderedLock>;
template class KernelTeam<SpeculativeLock>;

}  // namespace lumesh::operators
