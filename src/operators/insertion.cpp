#include "lumesh/operators/insertion.hpp"

#include <algorithm>
#include <cmath>

#include "apply.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
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
  return std::ranges::any_of(around, [&](std::uint32_t w) {
    const VertexId v(w);
    return mesh.dimension(v) <= vertex.dimension &&
           metric::edge_length(vertex.point, vertex.metric.metric, mesh.point(v), mesh.metric(v)) <
               min_length;
  });
}

/// Collapses the vertices that encroach on a new one onto it.
void draw_in_near_vertices(auto& site, VertexId into) {
  const CollapseRules rules{.max_length = 2, .min_quality = 1e-3, .min_relative_quality = 0.3};
  for (const VertexId v : site.scratch.cavity.too_near())
    site.counts[OperatorId::kCollapse].add(collapse_held_vertex(site, v, into, rules));
}

/// @param around  What holds the new vertex.
Outcome insert_in_hole(auto& site, const NewVertex& vertex, std::span<const TetId> around,
                       const InsertionRules& rules) {
  const TetMesh& mesh = site.mesh;
  Cavity& cavity = site.scratch.cavity;
  cavity.begin(around);
  if (!cavity.enlarge(mesh, vertex, rules.max_cavity_tets, site.lock) ||
      !cavity.shrink_to_star_shaped(mesh, vertex, site.subject.shapes) ||
      !cavity.accept(mesh, vertex, site.subject.shapes, rules))
    return Outcome::kRejected;
  const VertexId v = cavity.fill(site.scratch.builder, vertex);
  site.lock.take_ownership(v);
  draw_in_near_vertices(site, v);
  return Outcome::kApplied;
}

Outcome split_held_edge(auto& site, TetId t, VertexId a, VertexId b, double fraction,
                        const InsertionRules& rules) {
  TetMesh& mesh = site.mesh;
  EdgeRing& ring = site.scratch.ring;
  if (!gather_ring(mesh, t, a, b, site.lock, ring)) return Outcome::kContended;
  if (is_any_frozen(ring.patches, site.subject.shapes)) return Outcome::kRejected;
  const auto place = place_on_patches(point_on_edge(mesh, a, b, fraction), ring.patches, site.subject.shapes);
  if (!place) return Outcome::kRejected;

  NewVertex vertex;
  vertex.point = *place;
  vertex.hint = mesh.metric_hint(a);
  vertex.metric = site.subject.field.at(vertex.point, vertex.hint);
  vertex.dimension = ring.dimension();
  vertex.patches = ring.patches;
  vertex.edge_a = a, vertex.edge_b = b;
  if (is_encroaching(mesh, vertex, ring.rim, rules.min_length)) return Outcome::kRejected;
  return insert_in_hole(site, vertex, ring.tets, rules);
}

}  // namespace

bool EdgeSplit::would_fail(auto& site, const TetEdge& edge) const {
  const auto [a, b] = vertices_of(site.mesh, edge);
  return site.scratch.tried_splits.would_fail(a, b);  // Each tetrahedron around the edge asks for it again.
}

Outcome EdgeSplit::operator()(auto& site, const TetEdge& edge) const {
  const auto [a, b] = vertices_of(site.mesh, edge);
  // The same point whoever asks, and from which end.
  const Vec3 &p = site.mesh.point(a), &q = site.mesh.point(b);
  const Outcome outcome = precedes(q, p) ? split_held_edge(site, edge.tet, b, a, 1 - fraction, rules)
                                         : split_held_edge(site, edge.tet, a, b, fraction, rules);
  TriedEdges& tried = site.scratch.tried_splits;
  if (outcome == Outcome::kRejected && !site.lock.contended()) tried.note_failure(a, b);
  if (outcome == Outcome::kApplied) tried.note_change(site.scratch.cavity.hull_vertices());
  return outcome;
}

Outcome CentroidInsertion::operator()(auto& site, TetId t) const {
  const TetMesh& mesh = site.mesh;
  NewVertex vertex;
  vertex.point = mesh.centroid(t);
  vertex.hint = mesh.metric_hint(mesh.vertex(t, 0));
  vertex.metric = site.subject.field.at(vertex.point, vertex.hint);
  if (is_encroaching(mesh, vertex, mesh.tet(t), rules.min_length)) return Outcome::kRejected;
  return insert_in_hole(site, vertex, {&t, 1}, rules);
}

template struct OperatorCode<EdgeSplit>;
template struct OperatorCode<CentroidInsertion>;

}  // namespace lumesh::operators
