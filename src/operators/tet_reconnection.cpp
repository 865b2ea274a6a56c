#include <algorithm>

#include "apply.hpp"
#include "lumesh/operators/reconnection.hpp"

namespace lumesh::operators {

bool has_changed_since_trial(const TetMesh& mesh, TetId t, int min_vertices) {
  const std::uint32_t trial = mesh.trial_epoch(t);
  const Cell<4>& v = mesh.tet(t);
  // What changed in the epoch of the trial may have changed after it.
  return trial == 0 || std::ranges::count_if(v, [&](std::uint32_t w) {
                         return mesh.change_epoch(VertexId(w)) >= trial;
                       }) >= min_vertices;
}

Outcome TetReconnection::operator()(auto& site, TetId t) const {
  bool contended = false;
  const auto is_applied = [&](Outcome outcome) {
    contended |= outcome == Outcome::kContended;
    return outcome == Outcome::kApplied;
  };
  const TetMesh& mesh = site.mesh;
  const std::uint32_t epoch = site.scratch.builder.epoch;
  TriedEdges& tried = site.scratch.tried_removals;
  const Cell<4> corners = mesh.tet(t);
  // Of a tetrahedron that was tried before, only the edges around which something has changed; all faces,
  // since some go together with faces farther off.
  const std::uint32_t last_trial = rules.repeat ? 0 : mesh.trial_epoch(t);
  const auto has_changed = [&](VertexId v) { return mesh.change_epoch(v) >= last_trial; };
  const std::size_t made_before = site.scratch.builder.tets.size();
  const auto note_what_changed = [&] {
    if (rules.repeat) return Outcome::kApplied;  // Nobody asks.
    tried.note_change(corners);
    for (std::size_t i = made_before; i < site.scratch.builder.tets.size(); ++i)
      tried.note_change(mesh.tet(site.scratch.builder.tets[i]));
    return Outcome::kApplied;
  };
  for (const auto& [i, j] : kTetEdges) {
    const VertexId a = mesh.vertex(t, i), b = mesh.vertex(t, j);
    if (!has_changed(a) || !has_changed(b) || (!rules.repeat && tried.would_fail(a, b))) continue;
    const Outcome outcome = OperatorCode<EdgeRemoval>::apply(site, {rules}, {t, i, j});
    if (is_applied(outcome)) return note_what_changed();
    if (!rules.repeat && outcome == Outcome::kRejected) tried.note_failure(a, b);
  }
  for (int face = 0; face < 4; ++face) {
    // The neighbour tried the same face, and neither has changed since: new tetrahedra have no epoch yet, and
    // sweeps that move vertices set rules.repeat.
    const FaceLink link = mesh.link(t, face);
    if (!rules.repeat && !link.is_boundary() && mesh.trial_epoch(link.tet()) == epoch) continue;
    if (is_applied(OperatorCode<FaceRemoval>::apply(site, {rules}, {t, face}))) return note_what_changed();
  }
  if (contended) return Outcome::kContended;
  site.mesh.set_trial_epoch(t, epoch);
  return Outcome::kRejected;
}

template struct OperatorCode<TetReconnection>;

}  // namespace lumesh::operators
