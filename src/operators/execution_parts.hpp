#pragma once
/// @file Parts of both executions.

#include <vector>

#include "lumesh/operators/operators.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/team.hpp"

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
