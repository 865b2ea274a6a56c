#include "lumesh/operators/speculative_execution.hpp"

#include <algorithm>
#include <span>

#include "execution_parts.hpp"
#include "lumesh/operators/partition.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

/// Calls step and tells whether all it did was to contend.
template <class Step>
bool only_contends(const Kernel<SpeculativeLock>& kernel, const Step& step) {
  const OperatorCount before = kernel.counts().of_all();
  step();
  const OperatorCount after = kernel.counts().of_all();
  return after.contended > before.contended && after.applied == before.applied;
}

}  // namespace

SpeculativeExecution::SpeculativeExecution(const Subject& subject, const parallel::TeamOptions& team)
    : KernelTeam(subject, team) {
  reorder();
}

void SpeculativeExecution::reorder() {
  TetMesh& mesh = subject_.mesh;
  mesh.reorder_along_curve();
  share_slots(mesh, team_.size());
  stamp_ = 0;
}

template <class Item, class Attempt>
void SpeculativeExecution::run_buckets(std::vector<Item>& items, const Attempt& attempt) {
  run_in_buckets(team_, items, bucket_size_for(items.size()), [&](std::size_t thread) {
    Kernel& kernel = kernels_[thread];
    kernel.begin_run(SpeculativeLock(subject_.mesh, static_cast<std::uint32_t>(thread) + 1), stamp_, epoch_);
    return [&](const Item& item) { return is_told_to_stop_() || attempt(kernel, item); };
  });
}

template <class Id, class Priority, class Step>
void SpeculativeExecution::for_each_by_priority(std::size_t slots, const Priority& priority,
                                                const Step& step) {
  TetMesh& mesh = subject_.mesh;
  auto picked = parallel::collect<PrioritisedItem>(
      slots, kItemBlock, [&](std::size_t slot, std::vector<PrioritisedItem>& out) {
        const Id id(static_cast<std::uint32_t>(slot));
        if (!mesh.alive(id)) return;
        if (const auto value = static_cast<float>(priority(id)); value > 0) out.push_back({id.value, value});
      });
  parallel::for_each_block(picked.size(), bucket_size_for(picked.size()),
                           [&](std::size_t /*bucket*/, std::size_t begin, std::size_t end) {
                             const std::span bucket = std::span(picked).subspan(begin, end - begin);
                             std::ranges::stable_sort(bucket, has_higher_priority);
                           });
  ++epoch_;
  ++stamp_;
  run_buckets(picked, [&](Kernel& kernel, const PrioritisedItem& one) {
    const Id id(one.item);
    if (mesh.stamp(id) >= stamp_) return true;
    // What it was may change until its vertices are held. Whoever changes an element holds all its vertices,
    // old or new, while its stamp changes: if one that was read is of another element, the stamp says so by
    // now.
    const bool held = kernel.try_lock(id);
    bool again = !held;
    if (held && mesh.stamp(id) < stamp_) again = only_contends(kernel, [&] { step(kernel, id); });
    kernel.release();
    return !again;
  });
}

void SpeculativeExecution::for_each_tet_by_priority(const std::function<double(TetId)>& priority,
                                                    const std::function<void(Kernel&, TetId)>& step) {
  for_each_by_priority<TetId>(subject_.mesh.tet_slots(), priority, step);
}

void SpeculativeExecution::for_each_vertex_by_priority(const std::function<double(VertexId)>& priority,
                                                       const std::function<void(Kernel&, VertexId)>& step) {
  for_each_by_priority<VertexId>(subject_.mesh.vertex_slots(), priority, step);
}

void SpeculativeExecution::for_each_vertex(const std::function<void(Kernel&, VertexId)>& step) {
  TetMesh& mesh = subject_.mesh;
  auto vertices = parallel::collect<std::uint32_t>(
      mesh.vertex_slots(), kItemBlock, [&](std::size_t slot, std::vector<std::uint32_t>& out) {
        if (mesh.alive(VertexId(static_cast<std::uint32_t>(slot))))
          out.push_back(static_cast<std::uint32_t>(slot));
      });
  ++epoch_;
  ++stamp_;
  run_buckets(vertices, [&](Kernel& kernel, std::uint32_t v) {
    return !only_contends(kernel, [&] { step(kernel, VertexId(v)); });
  });
}

}  // namespace lumesh::operators
