#include "lumesh/operators/collapse.hpp"

#include <algorithm>

#include "apply.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

/// True if `from` may go where `to` is: within its patches, along an edge of them.
bool keeps_patches(const TetMesh& mesh, VertexId from, const EdgeRing& ring, const PatchShapes& shapes) {
  const VertexDimension dimension = mesh.dimension(from);
  if (dimension == VertexDimension::kVolume) return true;
  if (ring.dimension() != dimension) return false;  // A corner's never is.
  return !is_any_frozen(ring.patches, shapes);
}

/// True if the faces of curved patches keep to their surface when `from` goes where `to` is.
bool keeps_to_surface(const TetMesh& mesh, VertexId from, VertexId to, const VertexBall& ball,
                      const PatchShapes& shapes) {
  if (!is_any_curved(ball.patches, shapes)) return true;
  SurfaceDeviation before, after;
  for (const TetId t : ball.tets) {
    const int opposite = mesh.index_of(t, from);
    for (int f = 0; f < 4; ++f) {
      const PatchId patch = mesh.patch(t, f);
      if (f == opposite || !patch.valid() || shapes[patch.value].freedom != PatchFreedom::kCurved) continue;
      const Surface& surface = *shapes[patch.value].surface;
      Cell<3> corners = mesh.face_corners(t, f);
      before.add(surface, mesh, corners);
      if (std::ranges::find(corners, to.value) != corners.end()) continue;  // Vanishes.
      std::ranges::replace(corners, from.value, to.value);
      after.add(surface, mesh, corners);
    }
  }
  return after.may_follow(before);
}

/// True if the tetrahedra around the edge can vanish: not where one lies between two faces of patches, which
/// would become one.
bool can_vanish(const TetMesh& mesh, VertexId from, VertexId to, const EdgeRing& ring) {
  return std::ranges::none_of(ring.tets, [&](TetId t) {
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

bool contains(std::span<const std::uint32_t> all, std::uint32_t v) {
  return std::ranges::find(all, v) != all.end();
}

/// The edges opposite `centre` in the faces of its tetrahedra, with both ends among `ends`; lower end first.
void edges_of_link(const TetMesh& mesh, VertexId centre, std::span<const TetId> tets,
                   std::span<const std::uint32_t> ends, std::vector<std::uint64_t>& edges) {
  edges.clear();
  for (const TetId t : tets) {
    const Cell<3> far = mesh.face_corners(t, mesh.index_of(t, centre));
    for (int k = 0; k < 3; ++k)
      if (contains(ends, far[k]) && contains(ends, far[(k + 1) % 3]))
        edges.push_back(edge_key(far[k], far[(k + 1) % 3]));
  }
  sort_unique(edges);
}

/// The link condition: nothing joins `from` and `to`, vertex or edge, but what lies around their edge. Else
/// what is one with `from` and one with `to` would become the same twice. Where meshes are embedded positive
/// tetrahedra say so by themselves; where the surface moves, they do not. Source: the link condition for
/// 3-complexes of Dey, Edelsbrunner, Guha and Nekhayev 1999, Topology preserving edge contraction,
/// Publications de l'Institut Mathematique 66(80), 23-45 (no DOI).
bool meet_only_around_edge(const TetMesh& mesh, VertexId from, VertexId to, const EdgeRing& ring,
                           const VertexBall& ball_of_from, const VertexBall& ball_of_to, LinkEdges& edges) {
  for (const std::uint32_t v : ball_of_from.neighbours)
    if (v != to.value && !contains(ring.rim, v) && contains(ball_of_to.neighbours, v)) return false;
  edges_of_link(mesh, from, ball_of_from.tets, ring.rim, edges.of_from);
  edges_of_link(mesh, to, ball_of_to.tets, ring.rim, edges.of_to);
  std::size_t common = 0;
  for (const std::uint64_t edge : edges.of_from)
    if (std::ranges::binary_search(edges.of_to, edge)) ++common;
  return common == ring.tets.size();  // Each tetrahedron of the ring has one edge of its rim.
}

/// True if a face of the tetrahedra around `from` that is of a patch has the edge from there to w.
bool has_patch_edge(const TetMesh& mesh, VertexId from, std::uint32_t w, std::span<const TetId> tets) {
  return std::ranges::any_of(tets, [&](TetId t) {
    const int end = mesh.index_of(t, VertexId(w));
    if (end < 0) return false;
    const int own = mesh.index_of(t, from);
    for (int f = 0; f < 4; ++f)
      if (f != own && f != end && mesh.patch(t, f).valid()) return true;
    return false;
  });
}

/// The link condition of the patches: where edges of them run from `from` and from `to` to one vertex, so
/// does a face of them. Else two sheets of the surface would become one at the edge that is left.
bool patches_meet_only_around_edge(const TetMesh& mesh, VertexId from, VertexId to, const EdgeRing& ring,
                                   const VertexBall& ball_of_from, const VertexBall& ball_of_to) {
  if (ring.patch_faces == 0) return true;
  const auto is_face_of_patch = [&](std::uint32_t w) {
    return std::ranges::any_of(ring.tets, [&](TetId t) {
      for (int f = 0; f < 4 && mesh.index_of(t, VertexId(w)) >= 0; ++f)
        if (const VertexId v = mesh.vertex(t, f);
            v != from && v != to && v.value != w && mesh.patch(t, f).valid())
          return true;
      return false;
    });
  };
  return std::ranges::none_of(ring.rim, [&](std::uint32_t w) {
    return !is_face_of_patch(w) && has_patch_edge(mesh, from, w, ball_of_from.tets) &&
           has_patch_edge(mesh, to, w, ball_of_to.tets);
  });
}

/// True if an edge from `to` would be longer than allowed; where `from` has longer ones already, than the
/// longest.
bool makes_edge_too_long(const TetMesh& mesh, VertexId from, VertexId to, const VertexBall& ball,
                         double max_length) {
  double longest_new = max_length;
  for (const std::uint32_t w : ball.neighbours) {
    if (w == to.value) continue;
    // A length lies between those in the metrics of the two ends.
    const Vec3 edge = mesh.point(VertexId(w)) - mesh.point(to);
    if (std::max(mesh.metric(to).quadratic(edge), mesh.metric(VertexId(w)).quadratic(edge)) >
        max_length * max_length)
      longest_new = std::max(longest_new, metric_length(mesh, to, VertexId(w)));
  }
  return longest_new > max_length && std::ranges::none_of(ball.neighbours, [&](std::uint32_t w) {
           return metric_length(mesh, from, VertexId(w)) >= longest_new;
         });
}

/// The neighbours at less than `min_length`, the nearest first; equally near ones by coordinates.
void neighbours_near(const TetMesh& mesh, VertexId v, const VertexBall& ball, double min_length,
                     std::vector<NearVertex>& near) {
  near.clear();
  for (const std::uint32_t w : ball.neighbours)
    if (const double length = metric_length(mesh, v, VertexId(w)); length < min_length)
      near.push_back({VertexId(w), length});
  std::ranges::sort(near, [&](const NearVertex& a, const NearVertex& b) {
    if (a.length != b.length) return a.length < b.length;
    return precedes(mesh.point(a.vertex), mesh.point(b.vertex));
  });
}

/// True if the tetrahedra around `from` that do not vanish are positively oriented once it is where `to` is.
bool are_positive_after(const TetMesh& mesh, VertexId from, VertexId to, const VertexBall& ball,
                        const std::vector<float>& qualities) {
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    if (qualities[i] < 0) continue;
    Cell<4> v = mesh.tet(ball.tets[i]);
    v[mesh.index_of(ball.tets[i], from)] = to.value;
    if (orient3d(mesh.point(VertexId(v[0])), mesh.point(VertexId(v[1])), mesh.point(VertexId(v[2])),
                 mesh.point(VertexId(v[3]))) <= 0)
      return false;
  }
  return true;
}

/// Qualities of the tetrahedra around `from` once moved to `to`; negative where one vanishes. False if one
/// would be inverted or fall below the floor.
bool measure_after(const TetMesh& mesh, const ShapeMeasure& measure, VertexId from, VertexId to,
                   const VertexBall& ball, StarShapes& shapes, double floor, std::vector<float>& qualities) {
  const bool in_metric = measure.kind == ShapeMeasure::Kind::kMeanRatio;
  std::span<const double> cubes;
  if (in_metric) cubes = shapes.ratios_cubed_at(mesh.point(to), mesh.log_metric(to));
  const auto cubed_after = [&](TetId t) {
    Cell<4> v = mesh.tet(t);
    v[mesh.index_of(t, from)] = to.value;
    return quality_cubed(measure, mesh, VertexId(v[0]), VertexId(v[1]), VertexId(v[2]), VertexId(v[3]));
  };
  qualities.clear();
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    qualities.push_back(-1);
    if (mesh.index_of(ball.tets[i], to) >= 0) continue;
    const double cubed = in_metric ? cubes[i] : cubed_after(ball.tets[i]);
    if (!(cubed > 0) || cubed < metric::cube(floor))
      return false;  // The worst one before may be flat within rounding.
    qualities.back() = static_cast<float>(metric::cube_root(cubed));
  }
  return are_positive_after(mesh, from, to, ball, qualities);
}

/// Moves `from` to `to`, with the ball, the ring and the qualities afterwards in the scratch.
void commit_collapse(TetMesh& mesh, Scratch& scratch, VertexId from, VertexId to) {
  Builder& builder = scratch.builder;
  const VertexBall& ball = scratch.ball;
  const std::vector<float>& qualities = scratch.qualities;
  for (const TetId x : scratch.ring.tets) close_gap(mesh, x, mesh.index_of(x, from), mesh.index_of(x, to));
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    const TetId x = ball.tets[i];
    if (qualities[i] < 0) continue;
    Cell<4> v = mesh.tet(x);
    v[mesh.index_of(x, from)] = to.value;
    builder.change_tet(x, v);
    mesh.set_quality(x, qualities[i]);
    for (const std::uint32_t w : v) mesh.set_incident_tet(VertexId(w), x);
  }
  for (const TetId x : scratch.ring.tets) builder.free_tet(x);
  builder.free_vertex(from);
}

/// Collapses v onto the first admissible vertex of Scratch::near.
Outcome collapse_gathered_vertex(auto& site, VertexId v, const CollapseRules& rules) {
  const TetMesh& mesh = site.mesh;
  const VertexBall& ball = site.scratch.ball;
  EdgeRing& ring = site.scratch.ring;
  StarShapes& shapes = site.scratch.shapes;
  float worst = 1;
  for (const TetId x : ball.tets) worst = std::min(worst, mesh.quality(x));
  const double floor =
      worst < rules.min_quality ? worst : std::max(rules.min_quality, rules.min_relative_quality * worst);
  if (site.subject.measure.kind == ShapeMeasure::Kind::kMeanRatio) shapes.gather(mesh, v, ball.tets);
  for (const NearVertex& to : site.scratch.near) {
    const auto shared =
        std::ranges::find_if(ball.tets, [&](TetId x) { return mesh.index_of(x, to.vertex) >= 0; });
    if (shared == ball.tets.end()) continue;
    if (makes_edge_too_long(mesh, v, to.vertex, ball, rules.max_length)) continue;
    if (!measure_after(mesh, site.subject.measure, v, to.vertex, ball, shapes, floor, site.scratch.qualities))
      continue;
    // Within the ball, which is held.
    if (!gather_ring(mesh, *shared, v, to.vertex, site.lock, ring)) return Outcome::kContended;
    if (!keeps_patches(mesh, v, ring, site.subject.shapes) || !can_vanish(mesh, v, to.vertex, ring)) continue;
    if (!keeps_to_surface(mesh, v, to.vertex, ball, site.subject.shapes)) continue;
    if (mesh.dimension(to.vertex) != VertexDimension::kVolume) {
      if (!gather_ball(mesh, to.vertex, site.lock, site.scratch.other_ball)) return Outcome::kContended;
      if (!meet_only_around_edge(mesh, v, to.vertex, ring, ball, site.scratch.other_ball,
                                 site.scratch.link_edges))
        continue;
      if (!patches_meet_only_around_edge(mesh, v, to.vertex, ring, ball, site.scratch.other_ball)) continue;
    }
    commit_collapse(site.mesh, site.scratch, v, to.vertex);
    return Outcome::kApplied;
  }
  return Outcome::kRejected;
}

}  // namespace

Outcome collapse_held_vertex(auto& site, VertexId v, VertexId into, const CollapseRules& rules) {
  if (!gather_ball(site.mesh, v, site.lock, site.scratch.ball)) return Outcome::kContended;
  site.scratch.near.assign(1, {into, 0});
  return collapse_gathered_vertex(site, v, rules);
}

Outcome EdgeCollapse::operator()(auto& site, const TetEdge& edge) const {
  const auto [from, to] = vertices_of(site.mesh, edge);
  return collapse_held_vertex(site, from, to, rules);
}

Outcome VertexCollapse::operator()(auto& site, VertexId v) const {
  if (site.mesh.dimension(v) == VertexDimension::kCorner) return Outcome::kRejected;
  if (!gather_ball(site.mesh, v, site.lock, site.scratch.ball)) return Outcome::kContended;
  neighbours_near(site.mesh, v, site.scratch.ball, min_length, site.scratch.near);
  return collapse_gathered_vertex(site, v, rules);
}

Outcome Thinning::operator()(auto& site, VertexId v) const {
  TetMesh& mesh = site.mesh;
  VertexBall& ball = site.scratch.ball;
  if (kept[v.value] != 0 || mesh.dimension(v) == VertexDimension::kCorner) return Outcome::kRejected;
  if (!gather_ball(mesh, v, site.lock, ball)) return Outcome::kContended;
  if (is_any_curved(ball.patches, site.subject.shapes)) return Outcome::kRejected;
  UniformStar& star = site.scratch.uniform;
  star.gather(mesh, v, ball);
  const double floor_cubed = std::min(star.worst_cubed(), metric::cube(rules.min_quality));
  for (std::uint32_t place = 0; star.next_nearest(rules.min_length, place);) {
    const VertexId to(ball.neighbours[place]);
    if (!star.fits_at(place, floor_cubed, site.scratch.qualities)) continue;
    if (!are_positive_after(mesh, v, to, ball, site.scratch.qualities)) continue;
    const auto shared = std::ranges::find_if(ball.tets, [&](TetId x) { return mesh.index_of(x, to) >= 0; });
    if (!gather_ring(mesh, *shared, v, to, site.lock, site.scratch.ring)) return Outcome::kContended;
    if (!keeps_patches(mesh, v, site.scratch.ring, site.subject.shapes)) continue;
    if (!can_vanish(mesh, v, to, site.scratch.ring)) continue;
    commit_collapse(mesh, site.scratch, v, to);
    kept[to.value] = 1;
    return Outcome::kApplied;
  }
  return Outcome::kRejected;
}

template struct OperatorCode<EdgeCollapse>;
template struct OperatorCode<VertexCollapse>;
template struct OperatorCode<Thinning>;
template Outcome collapse_held_vertex(Site<NoLock>&, VertexId, VertexId, const CollapseRules&);
template Outcome collapse_held_vertex(Site<OrderedLock>&, VertexId, VertexId, const CollapseRules&);
template Outcome collapse_held_vertex(Site<SpeculativeLock>&, VertexId, VertexId, const CollapseRules&);

}  // namespace lumesh::operators
