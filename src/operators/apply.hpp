#pragma once
/// @file Running an operator: what every one of them has in common. Its file ends with an instance for every
/// lock, `template struct OperatorCode<TheOperator>;`.

#include <algorithm>
#include <array>
#include <span>

#include "lumesh/core/assert.hpp"
#include "scratch.hpp"
#include "soundness.hpp"

namespace lumesh::operators {

/// Frees what was locked since it was made.
template <class Lock>
class LockScope {
 public:
  explicit LockScope(Lock& lock) : lock_(lock), mark_(lock.mark()) {}
  ~LockScope() { lock_.release_to(mark_); }
  LockScope(const LockScope&) = delete;
  LockScope& operator=(const LockScope&) = delete;

 private:
  Lock& lock_;
  std::size_t mark_;
};

/// Vertices of a target, which are held while an operator runs.
[[nodiscard]] inline std::array<VertexId, 1> vertices_of(const TetMesh& /*mesh*/, VertexId v) {
  return {v};
}
[[nodiscard]] inline std::array<VertexId, 2> vertices_of(const TetMesh& mesh, const TetEdge& edge) {
  return {mesh.vertex(edge.tet, edge.from), mesh.vertex(edge.tet, edge.to)};
}
[[nodiscard]] inline std::array<VertexId, 4> vertices_of(const TetMesh& mesh, TetId t) {
  return {mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2), mesh.vertex(t, 3)};
}
[[nodiscard]] inline std::array<VertexId, 4> vertices_of(const TetMesh& mesh, const TetFace& face) {
  return vertices_of(mesh, face.tet);
}

template <Operator T, class Lock>
Outcome apply(Site<Lock>& site, const T& operation, const typename T::Target& target) {
  LUMESH_DEBUG_ASSERT(suits<T>(site.subject.measure.kind));
  if constexpr (!requires { T::kId; }) {
    return operation(site, target);
  } else {
    if constexpr (requires { operation.would_fail(site, target); })
      if (operation.would_fail(site, target)) return Outcome::kRejected;
    const auto held = vertices_of(site.mesh, target);
    const LockScope scope(site.lock);
    const std::size_t made = site.scratch.builder.tets.size();
    const bool is_held = std::ranges::all_of(held, [&](VertexId v) { return site.lock.try_lock(v); });
    Outcome outcome = is_held ? operation(site, target) : Outcome::kContended;
    if (outcome == Outcome::kRejected && site.lock.contended()) outcome = Outcome::kContended;
    site.counts[T::kId].add(outcome);
    LUMESH_PARANOID_ASSERT(outcome != Outcome::kApplied ||
                           (are_sound(site.mesh, std::span(site.scratch.builder.tets).subspan(made)) &&
                            is_sound_around(site.mesh, held[0])));
    return outcome;
  }
}

template <Operator T>
Outcome OperatorCode<T>::apply(Site<NoLock>& site, const T& operation, const Target& target) {
  return operators::apply(site, operation, target);
}
template <Operator T>
Outcome OperatorCode<T>::apply(Site<OrderedLock>& site, const T& operation, const Target& target) {
  return operators::apply(site, operation, target);
}
template <Operator T>
Outcome OperatorCode<T>::apply(Site<SpeculativeLock>& site, const T& operation, const Target& target) {
  return operators::apply(site, operation, target);
}

}  // namespace lumesh::operators
