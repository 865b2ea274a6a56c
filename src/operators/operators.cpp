#include "lumesh/operators/operators.hpp"

#include <algorithm>

#include "scratch.hpp"

namespace lumesh::operators {

std::array<int, 2> other_corners(int i, int j) {
  std::array<int, 2> others{};
  for (int k = 0, n = 0; k < 4; ++k)
    if (k != i && k != j) others[n++] = k;
  // (i, j, first, second) must be an even permutation of (0, 1, 2, 3).
  const std::array<int, 4> order = {i, j, others[0], others[1]};
  int inversions = 0;
  for (int k = 0; k < 4; ++k)
    for (int m = k + 1; m < 4; ++m) inversions += order[k] > order[m] ? 1 : 0;
  if (inversions % 2 != 0) std::swap(others[0], others[1]);
  return others;
}

OperatorCounts ExecutionCounts::of_all_threads() const {
  OperatorCounts sum;
  for (const OperatorCounts& counts : by_thread) sum += counts;
  return sum;
}

ExecutionCounts& ExecutionCounts::operator+=(const ExecutionCounts& other) {
  by_thread.resize(other.by_thread.size());
  migrations.resize(other.migrations.size());
  for (std::size_t thread = 0; thread < by_thread.size(); ++thread) {
    by_thread[thread] += other.by_thread[thread];
    migrations[thread] += other.migrations[thread];
  }
  return *this;
}

template <class Lock>
Operators<Lock>::Operators(const Subject& subject, Lock lock, int owner)
    : subject_(subject), lock_(std::move(lock)), scratch_(std::make_shared<Scratch>(subject.mesh, owner)) {
  LUMESH_ASSERT(subject.mesh.has_metric());
  LUMESH_ASSERT(subject.shapes.size() == subject.mesh.info().patches.size());
}

template <class Lock>
void Operators<Lock>::begin_run(const Lock& lock, std::uint32_t stamp, std::uint32_t epoch) {
  lock_ = lock;
  scratch_->builder.stamp = stamp;
  scratch_->builder.epoch = epoch;
  scratch_->tried_splits.clear();
  scratch_->tried_removals.clear();
  scratch_->builder.tets.clear();
  scratch_->builder.vertices.clear();
}

template <class Lock>
const std::vector<TetId>& Operators<Lock>::made_tets() const {
  return scratch_->builder.tets;
}

template <class Lock>
const std::vector<VertexId>& Operators<Lock>::made_vertices() const {
  return scratch_->builder.vertices;
}

bool has_changed_since_trial(const TetMesh& mesh, TetId t, int min_vertices) {
  const std::uint32_t trial = mesh.trial_epoch(t);
  const Cell<4>& v = mesh.tet(t);
  // What changed in the epoch of the trial may have changed after it.
  return trial == 0 || std::count_if(v.begin(), v.end(), [&](std::uint32_t w) {
                         return mesh.change_epoch(VertexId(w)) >= trial;
                       }) >= min_vertices;
}

template <class Lock>
Outcome Operators<Lock>::reconnect(TetId t, const SwapRules& rules) {
  bool contended = false;
  const auto is_applied = [&](Outcome outcome) {
    contended |= outcome == Outcome::kContended;
    return outcome == Outcome::kApplied;
  };
  const TetMesh& mesh = subject_.mesh;
  const std::uint32_t epoch = scratch_->builder.epoch;
  TriedEdges& tried = scratch_->tried_removals;
  const Cell<4> corners = mesh.tet(t);
  // Of a tetrahedron that was tried before, only the edges around which something has changed; all faces,
  // since some go together with faces farther off.
  const std::uint32_t last_trial = rules.repeat ? 0 : mesh.trial_epoch(t);
  const auto has_changed = [&](VertexId v) { return mesh.change_epoch(v) >= last_trial; };
  const std::size_t made_before = scratch_->builder.tets.size();
  const auto note_what_changed = [&] {
    if (rules.repeat) return Outcome::kApplied;  // Nobody asks.
    tried.note_change(corners);
    for (std::size_t i = made_before; i < scratch_->builder.tets.size(); ++i)
      tried.note_change(mesh.tet(scratch_->builder.tets[i]));
    return Outcome::kApplied;
  };
  for (const auto& [i, j] : kTetEdges) {
    const VertexId a = mesh.vertex(t, i), b = mesh.vertex(t, j);
    if (!has_changed(a) || !has_changed(b) || (!rules.repeat && tried.would_fail(a, b))) continue;
    const Outcome outcome = remove_edge(t, i, j, rules);
    if (is_applied(outcome)) return note_what_changed();
    if (!rules.repeat && outcome == Outcome::kRejected) tried.note_failure(a, b);
  }
  for (int face = 0; face < 4; ++face) {
    // The neighbour tried the same face, and neither has changed since: what is made anew carries no note,
    // and a sweep that moves vertices asks for repeat.
    const FaceLink link = mesh.link(t, face);
    if (!rules.repeat && !link.is_boundary() && mesh.trial_epoch(link.tet()) == epoch) continue;
    if (is_applied(remove_face(t, face, rules))) return note_what_changed();
  }
  if (contended) return Outcome::kContended;
  subject_.mesh.set_trial_epoch(t, epoch);
  return Outcome::kRejected;
}

template <class Lock>
bool Operators<Lock>::try_lock(TetId t) {
  const Cell<4> v = subject_.mesh.unheld_tet(t);
  return std::none_of(v.begin(), v.end(), [](std::uint32_t corner) { return corner == VertexId::kNone; }) &&
         std::all_of(v.begin(), v.end(),
                     [&](std::uint32_t corner) { return lock_.try_lock(VertexId(corner)); });
}

// Member by member: the other files of this module instantiate theirs.
template Operators<NoLock>::Operators(const Subject&, NoLock, int);
template void Operators<NoLock>::begin_run(const NoLock&, std::uint32_t, std::uint32_t);
template const std::vector<TetId>& Operators<NoLock>::made_tets() const;
template const std::vector<VertexId>& Operators<NoLock>::made_vertices() const;
template Outcome Operators<NoLock>::reconnect(TetId, const SwapRules&);
template bool Operators<NoLock>::try_lock(TetId);

template Operators<OrderedLock>::Operators(const Subject&, OrderedLock, int);
template void Operators<OrderedLock>::begin_run(const OrderedLock&, std::uint32_t, std::uint32_t);
template const std::vector<TetId>& Operators<OrderedLock>::made_tets() const;
template const std::vector<VertexId>& Operators<OrderedLock>::made_vertices() const;
template Outcome Operators<OrderedLock>::reconnect(TetId, const SwapRules&);
template bool Operators<OrderedLock>::try_lock(TetId);

template Operators<SpeculativeLock>::Operators(const Subject&, SpeculativeLock, int);
template void Operators<SpeculativeLock>::begin_run(const SpeculativeLock&, std::uint32_t, std::uint32_t);
template const std::vector<TetId>& Operators<SpeculativeLock>::made_tets() const;
template const std::vector<VertexId>& Operators<SpeculativeLock>::made_vertices() const;
template Outcome Operators<SpeculativeLock>::reconnect(TetId, const SwapRules&);
template bool Operators<SpeculativeLock>::try_lock(TetId);

}  // namespace lumesh::operators
