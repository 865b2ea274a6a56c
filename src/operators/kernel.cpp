#include "lumesh/operators/kernel.hpp"

#include <algorithm>

#include "lumesh/core/assert.hpp"
#include "scratch.hpp"

namespace lumesh::operators {

template <class Lock>
Kernel<Lock>::Kernel(const Subject& subject, Lock lock, int owner)
    : subject_(subject), lock_(std::move(lock)), scratch_(std::make_shared<Scratch>(subject.mesh, owner)) {
  LUMESH_ASSERT(subject.mesh.has_metric());
  LUMESH_ASSERT(subject.shapes.size() == subject.mesh.info().patches.size());
}

template <class Lock>
void Kernel<Lock>::begin_run(const Lock& lock, std::uint32_t stamp, std::uint32_t epoch) {
  lock_ = lock;
  scratch_->builder.stamp = stamp;
  scratch_->builder.epoch = epoch;
  scratch_->tried_splits.clear();
  scratch_->tried_removals.clear();
  scratch_->builder.tets.clear();
  scratch_->builder.vertices.clear();
}

template <class Lock>
const std::vector<TetId>& Kernel<Lock>::made_tets() const {
  return scratch_->builder.tets;
}

template <class Lock>
const std::vector<VertexId>& Kernel<Lock>::made_vertices() const {
  return scratch_->builder.vertices;
}

template <class Lock>
bool Kernel<Lock>::try_lock(TetId t) {
  const Cell<4> v = subject_.mesh.unheld_tet(t);
  return std::ranges::none_of(v, [](std::uint32_t corner) { return corner == VertexId::kNone; }) &&
         std::ranges::all_of(v, [&](std::uint32_t corner) { return lock_.try_lock(VertexId(corner)); });
}

template class Kernel<NoLock>;
template class Kernel<OrderedLock>;
template class Kernel<SpeculativeLock>;

}  // namespace lumesh::operators
