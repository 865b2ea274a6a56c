#include <algorithm>

#include "scratch.hpp"

namespace lumesh::operators {
namespace {

/// True if `from` may go where `to` is: within its patches, along an edge of them.
bool keeps_patches(const TetMesh& mesh, VertexId from, const EdgeRing& ring, const PatchShapes& shapes) {
  const VertexDimension dimension = mesh.dimension(from);
  if (dimension == VertexDimension::kVolume) return true;
  if (ring.dimension() != dimension) return false;  // A corner's never is.
  return std::all_of(ring.patches.begin(), ring.patches.end(),
                     [&](PatchId patch) { return shapes[patch.value].freedom == PatchFreedom::kPlane; });
}

/// True if the tetrahedra around the edge can vanish: not where one lies between two faces of patches, which
/// would become one.
bool can_vanish(const TetMesh& mesh, VertexId from, VertexId to, const EdgeRing& ring) {
  return std::none_of(ring.tets.begin(), ring.tets.end(), [&](TetId t) {
    return mesh.patch(t, mesh.index_of(t, from)).valid() && mesh.patch(t, mesh.index_of(t, to)).valid();
  });
}

/// Joins what lies on both sides of a tetrahedron that vanishes.
void close_gap(TetMesh& mesh, TetId t, int from, int to) {
  const FaceLink one = mesh.link(t, from), other = mesh.link(t, to);
  const PatchId patch = mesh.patch(t, from).valid() ? mesh.patch(t, from) : mesh.patch(t, to);
  if (one.is_boundary()) {
    mesh.set_link(other.tet(), other.face(), one);
    return;
  }
  link_to(mesh, one.tet(), one.face(), other);
  for (const std::uint32_t v : mesh.face_corners(one.tet(), one.face()))
    mesh.set_incident_tet(VertexId(v), one.tet());
  if (other.is_boundary() || !mesh.has_interfaces()) return;
  mesh.set_interface_patch(one.tet(), one.face(), patch);
  mesh.set_interface_patch(other.tet(), other.face(), patch);
}

/// True if an edge from b would be longer than allowed; where `from` has longer ones already, than the
/// longest.
bool makes_edge_too_long(const TetMesh& mesh, VertexId from, VertexId to, const VertexBall& ball,
                         double most) {
  double longest_new = 0;
  for (const std::uint32_t w : ball.neighbours)
    if (w != to.value) longest_new = std::max(longest_new, metric_length(mesh, to, VertexId(w)));
  return longest_new > most &&
         std::none_of(ball.neighbours.begin(), ball.neighbours.end(),
                      [&](std::uint32_t w) { return metric_length(mesh, from, VertexId(w)) >= longest_new; });
}

}  // namespace

template <class Lock>
Outcome Operators<Lock>::collapse_edge(TetId t, int from, int to, const CollapseRules& rules) {
  const VertexId a = subject_.mesh.vertex(t, from), b = subject_.mesh.vertex(t, to);
  return on_held(counts_.collapse, a, b, [&] { return collapse_held_edge(t, a, b, rules); });
}

template <class Lock>
Outcome Operators<Lock>::collapse_held_edge(TetId t, VertexId a, VertexId b, const CollapseRules& rules) {
  TetMesh& mesh = subject_.mesh;
  auto& [builder, ring, ball, cavity, qualities, near, shapes, angles] = *scratch_;
  if (mesh.dimension(a) == VertexDimension::kCorner) return Outcome::kRejected;
  if (!gather_ring(mesh, t, a, b, lock_, ring)) return Outcome::kContended;
  if (!keeps_patches(mesh, a, ring, subject_.shapes) || !can_vanish(mesh, a, b, ring))
    return Outcome::kRejected;
  if (!gather_ball(mesh, a, lock_, ball)) return Outcome::kContended;

  if (makes_edge_too_long(mesh, a, b, ball, rules.most_length)) return Outcome::kRejected;
  float worst = 1;
  for (const TetId x : ball.tets) worst = std::min(worst, mesh.quality(x));
  const double floor =
      worst < rules.least_quality ? worst : std::max(rules.least_quality, rules.least_relative * worst);
  qualities.clear();
  for (const TetId x : ball.tets) {
    qualities.push_back(-1);  // Vanishes.
    if (mesh.index_of(x, b) >= 0) continue;
    Cell<4> v = mesh.tet(x);
    v[mesh.index_of(x, a)] = b.value;
    const VertexId p(v[0]), q(v[1]), r(v[2]), s(v[3]);
    const double cubed = quality_cubed(subject_.measure, mesh, p, q, r, s);
    if (cubed < floor * floor * floor ||
        orient3d(mesh.point(p), mesh.point(q), mesh.point(r), mesh.point(s)) <= 0)
      return Outcome::kRejected;
    qualities.back() = static_cast<float>(metric::cube_root(cubed));
  }

  for (const TetId x : ring.tets) close_gap(mesh, x, mesh.index_of(x, a), mesh.index_of(x, b));
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    const TetId x = ball.tets[i];
    if (qualities[i] < 0) continue;
    Cell<4> v = mesh.tet(x);
    v[mesh.index_of(x, a)] = b.value;
    builder.change_tet(x, v);
    mesh.set_quality(x, qualities[i]);
    for (const std::uint32_t w : v) mesh.set_incident_tet(VertexId(w), x);
  }
  for (const TetId x : ring.tets) builder.free_tet(x);
  builder.free_vertex(a);
  return Outcome::kApplied;
}

template Outcome Operators<NoLock>::collapse_edge(TetId, int, int, const CollapseRules&);
template Outcome Operators<NoLock>::collapse_held_edge(TetId, VertexId, VertexId, const CollapseRules&);
template Outcome Operators<OrderedLock>::collapse_edge(TetId, int, int, const CollapseRules&);
template Outcome Operators<OrderedLock>::collapse_held_edge(TetId, VertexId, VertexId, const CollapseRules&);

}  // namespace lumesh::operators
