#include <algorithm>
#include <cmath>

#include "scratch.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

/// The point that divides the metric length of edge (a, b) so that `fraction` of it lies on a's side, for
/// sizes that vary geometrically along the edge. Coordinates that both ends share stay exactly the same.
Vec3 point_on_edge(const TetMesh& mesh, VertexId a, VertexId b, double fraction) {
  const Vec3 edge = mesh.point(b) - mesh.point(a);
  const double ratio = std::sqrt(mesh.metric(b).quadratic(edge) / mesh.metric(a).quadratic(edge));
  // The length up to t is proportional to (ratio^t - 1) / (ratio - 1).
  constexpr double kNearlyOne = 1e-3, kMargin = 0.1;
  double t = fraction;
  if (std::abs(ratio - 1) > kNearlyOne) t = std::log(1 + fraction * (ratio - 1)) / std::log(ratio);
  t = std::clamp(t, kMargin, 1 - kMargin);
  return mesh.point(a) + t * edge;
}

/// True if a vertex that stays is too near to the new one.
bool is_encroaching(const TetMesh& mesh, const NewVertex& vertex, std::span<const std::uint32_t> around,
                    double min_length) {
  return std::any_of(around.begin(), around.end(), [&](std::uint32_t w) {
    const VertexId v(w);
    return mesh.dimension(v) <= vertex.dimension &&
           metric::edge_length(vertex.point, vertex.metric.metric, mesh.point(v), mesh.metric(v)) <
               min_length;
  });
}

}  // namespace

template <class Lock>
Outcome Operators<Lock>::split_edge(TetId t, int i, int j, double fraction, const InsertionRules& rules) {
  const VertexId a = subject_.mesh.vertex(t, i), b = subject_.mesh.vertex(t, j);
  // Each tetrahedron around the edge asks for it again.
  TriedEdges& tried = scratch_->tried_splits;
  if (tried.would_fail(a, b)) return Outcome::kRejected;
  const Outcome outcome = on_held(counts_.insertion, a, b, [&] {
    // The same point whoever asks, and from which end.
    const Vec3 &p = subject_.mesh.point(a), &q = subject_.mesh.point(b);
    return std::lexicographical_compare(q.begin(), q.end(), p.begin(), p.end())
               ? split_held_edge(t, b, a, 1 - fraction, rules)
               : split_held_edge(t, a, b, fraction, rules);
  });
  if (outcome == Outcome::kRejected) tried.note_failure(a, b);
  if (outcome == Outcome::kApplied) tried.note_change(scratch_->cavity.hull_vertices());
  return outcome;
}

template <class Lock>
Outcome Operators<Lock>::split_held_edge(TetId t, VertexId a, VertexId b, double fraction,
                                         const InsertionRules& rules) {
  TetMesh& mesh = subject_.mesh;
  EdgeRing& ring = scratch_->ring;
  if (!gather_ring(mesh, t, a, b, lock_, ring)) return Outcome::kContended;
  if (is_any_frozen(ring.patches, subject_.shapes)) return Outcome::kRejected;
  const auto place = place_on_patches(point_on_edge(mesh, a, b, fraction), ring.patches, subject_.shapes);
  if (!place) return Outcome::kRejected;

  NewVertex vertex;
  vertex.point = *place;
  vertex.hint = mesh.metric_hint(a);
  vertex.metric = subject_.field.at(vertex.point, vertex.hint);
  vertex.dimension = ring.dimension();
  vertex.patches = ring.patches;
  vertex.edge_a = a, vertex.edge_b = b;
  if (is_encroaching(mesh, vertex, ring.rim, rules.min_length)) return Outcome::kRejected;
  return insert_in_hole(vertex, ring.tets, rules);
}

template <class Lock>
Outcome Operators<Lock>::insert_centroid(TetId t, const InsertionRules& rules) {
  const TetMesh& mesh = subject_.mesh;
  return on_held(counts_.insertion, mesh.vertex(t, 0), mesh.vertex(t, 1), [&] {
    if (!try_lock(t)) return Outcome::kContended;
    NewVertex vertex;
    vertex.point = 0.25 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2) + mesh.corner(t, 3));
    vertex.hint = mesh.metric_hint(mesh.vertex(t, 0));
    vertex.metric = subject_.field.at(vertex.point, vertex.hint);
    if (is_encroaching(mesh, vertex, mesh.tet(t), rules.min_length)) return Outcome::kRejected;
    return insert_in_hole(vertex, {&t, 1}, rules);
  });
}

/// @param around  What holds the new vertex.
template <class Lock>
Outcome Operators<Lock>::insert_in_hole(const NewVertex& vertex, std::span<const TetId> around,
                                        const InsertionRules& rules) {
  const TetMesh& mesh = subject_.mesh;
  Cavity& cavity = scratch_->cavity;
  cavity.begin(around);
  if (!cavity.enlarge(mesh, vertex, rules.max_cavity_tets, lock_) ||
      !cavity.shrink_to_star_shaped(mesh, vertex, subject_.shapes) ||
      !cavity.accept(mesh, vertex, subject_.shapes, rules))
    return Outcome::kRejected;
  const VertexId v = cavity.fill(scratch_->builder, vertex);
  lock_.take_ownership(v);
  if (!cavity.too_near().empty()) draw_in_near_vertices(v);
  return Outcome::kApplied;
}

template <class Lock>
void Operators<Lock>::draw_in_near_vertices(VertexId into) {
  const CollapseRules rules{.max_length = 2, .min_quality = 1e-3, .min_relative_quality = 0.3};
  TetMesh& mesh = subject_.mesh;
  Scratch& scratch = *scratch_;
  scratch.encroaching.assign(scratch.cavity.too_near().begin(), scratch.cavity.too_near().end());
  for (const VertexId v : scratch.encroaching) {
    scratch.near.assign(1, {into, 0});
    counts_.collapse.add(gather_ball(mesh, v, lock_, scratch.ball) ? collapse_gathered_vertex(v, rules)
                                                                   : Outcome::kContended);
  }
}

template Outcome Operators<NoLock>::split_edge(TetId, int, int, double, const InsertionRules&);
template Outcome Operators<NoLock>::insert_centroid(TetId, const InsertionRules&);
template Outcome Operators<OrderedLock>::split_edge(TetId, int, int, double, const InsertionRules&);
template Outcome Operators<OrderedLock>::insert_centroid(TetId, const InsertionRules&);
template Outcome Operators<SpeculativeLock>::split_edge(TetId, int, int, double, const InsertionRules&);
template Outcome Operators<SpeculativeLock>::insert_centroid(TetId, const InsertionRules&);

}  // namespace lumesh::operators
