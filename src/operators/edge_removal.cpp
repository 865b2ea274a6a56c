#include <algorithm>
#include <array>
#include <limits>

#include "apply.hpp"
#include "lumesh/operators/reconnection.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

struct Triangle {
  int i, j, k;  // Of the rim, i < j < k.
};

/// The triangulation of the rim of an edge (a, b) whose tetrahedra, one to a and one to b on each triangle,
/// have the best worst quality; all of it in cubes of qualities.
class RimTriangulation {
 public:
  RimTriangulation(const TetMesh& mesh, const ShapeMeasure& measure, const EdgeRing& ring, VertexId a,
                   VertexId b)
      : mesh_(mesh),
        measure_(measure),
        rim_(ring.rim),
        a_(a),
        b_(b),
        size_(static_cast<int>(ring.rim.size())),
        is_open_(ring.open) {}

  /// @param max_length  Of each new edge between vertices of the rim.
  /// @return false if none is better than `min_quality`.
  bool find(double min_quality, double max_length);
  [[nodiscard]] std::span<const Triangle> triangles() const { return {triangles_.data(), count_}; }
  /// Positive by the exact predicate?
  [[nodiscard]] bool is_positive() const;

  /// The tetrahedra on a triangle; both have it as face 3.
  [[nodiscard]] Cell<4> towards_b(const Triangle& x) const {
    return {rim_[x.i], rim_[x.j], rim_[x.k], b_.value};
  }
  [[nodiscard]] Cell<4> towards_a(const Triangle& x) const {
    return {rim_[x.k], rim_[x.j], rim_[x.i], a_.value};
  }

 private:
  [[nodiscard]] double cubed(const Cell<4>& v) const {
    return quality_cubed(measure_, mesh_, VertexId(v[0]), VertexId(v[1]), VertexId(v[2]), VertexId(v[3]));
  }
  void collect(int i, int k);

  const TetMesh& mesh_;
  const ShapeMeasure& measure_;
  const std::vector<std::uint32_t>& rim_;
  VertexId a_, b_;
  int size_;
  bool is_open_;
  // Of the polygon i, i + 1, ..., k closed by an edge: the best worst quality, and the corner of the triangle
  // on that edge.
  std::array<std::array<double, kMaxRing>, kMaxRing> best_;
  std::array<std::array<int, kMaxRing>, kMaxRing> corner_;
  std::array<Triangle, kMaxRing> triangles_;
  std::size_t count_ = 0;
};

bool RimTriangulation::find(double min_quality, double max_length) {
  const auto is_too_long = [&](int i, int k) {
    const bool is_new = is_open_ || k - i < size_ - 1;
    return is_new && is_longer_than(max_length, mesh_, VertexId(rim_[i]), VertexId(rim_[k]));
  };
  for (int i = 0; i + 1 < size_; ++i) best_[i][i + 1] = std::numeric_limits<double>::infinity();
  for (int length = 2; length < size_; ++length) {
    for (int i = 0, k = length; k < size_; ++i, ++k) {
      best_[i][k] = -1;
      if (is_too_long(i, k)) continue;
      for (int j = i + 1; j < k; ++j) {
        double worst = std::min(best_[i][j], best_[j][k]);
        const double needed = std::max(best_[i][k], min_quality);
        if (worst <= needed) continue;
        worst = std::min(worst, cubed(towards_b({i, j, k})));
        if (worst <= needed) continue;
        worst = std::min(worst, cubed(towards_a({i, j, k})));
        if (worst <= needed) continue;
        best_[i][k] = worst;
        corner_[i][k] = j;
      }
    }
  }
  if (best_[0][size_ - 1] <= min_quality) return false;
  count_ = 0;
  collect(0, size_ - 1);
  return true;
}

void RimTriangulation::collect(int i, int k) {
  if (k - i < 2) return;
  const int j = corner_[i][k];
  triangles_[count_++] = {i, j, k};
  collect(i, j);
  collect(j, k);
}

bool RimTriangulation::is_positive() const {
  const auto positive = [&](const Cell<4>& v) {
    return orient3d(mesh_.point(VertexId(v[0])), mesh_.point(VertexId(v[1])), mesh_.point(VertexId(v[2])),
                    mesh_.point(VertexId(v[3]))) > 0;
  };
  return std::all_of(triangles().begin(), triangles().end(),
                     [&](const Triangle& x) { return positive(towards_b(x)) && positive(towards_a(x)); });
}

/// Puts the tetrahedra of a triangulation in the place of those of the ring.
class RingReplacement {
 public:
  RingReplacement(Builder& builder, const ShapeMeasure& measure, const EdgeRing& ring, VertexId a, VertexId b)
      : builder_(builder),
        mesh_(builder.mesh),
        measure_(measure),
        ring_(ring),
        size_(static_cast<int>(ring.rim.size())) {
    for (std::size_t k = 0; k < ring.tets.size(); ++k) {
      const TetId t = ring.tets[k];
      behind_a_[k] = side_of(mesh_, t, mesh_.index_of(t, a));
      behind_b_[k] = side_of(mesh_, t, mesh_.index_of(t, b));
    }
    for (auto& row : open_) row.fill({});
  }

  void apply(const RimTriangulation& triangulation) {
    const Label label = mesh_.label(ring_.tets[0]);
    for (const TetId t : ring_.tets) builder_.free_tet(t);
    for (const Triangle& x : triangulation.triangles()) {
      const Pair made = {add(triangulation.towards_b(x), label), add(triangulation.towards_a(x), label)};
      link_to(mesh_, made.b, 3, FaceLink::to(made.a, 3));
      // Faces of (i, j, k, b) and (k, j, i, a) across the triangle's edges, by the corner opposite.
      connect(x.i, x.j, made, 2, 0);
      connect(x.j, x.k, made, 0, 2);
      connect(x.i, x.k, made, 1, 1);
    }
  }

 private:
  struct Pair {
    TetId b, a;
  };
  struct OpenFaces {
    FaceLink b, a;
    bool waiting = false;
  };

  TetId add(const Cell<4>& v, Label label) {
    const TetId t = builder_.add_tet(v, label);
    mesh_.set_quality(
        t, static_cast<float>(metric::cube_root(quality_cubed(measure_, mesh_, VertexId(v[0]), VertexId(v[1]),
                                                              VertexId(v[2]), VertexId(v[3])))));
    for (const std::uint32_t w : v) mesh_.set_incident_tet(VertexId(w), t);
    return t;
  }
  /// Links the faces of a pair of tetrahedra over the rim's edge (u, v), u < v.
  void connect(int u, int v, const Pair& made, int face_b, int face_a) {
    const bool last = u == 0 && v == size_ - 1;
    if (v == u + 1 || (last && !ring_.open)) {
      const auto k = static_cast<std::size_t>(last && v != u + 1 ? v : u);
      put_behind(mesh_, made.b, face_b, behind_a_[k]);  // The old face opposite a has b at its top.
      put_behind(mesh_, made.a, face_a, behind_b_[k]);
    } else if (last) {  // The new faces of the outside.
      mesh_.set_link(made.b, face_b, FaceLink::boundary(ring_.patches[0]));
      mesh_.set_link(made.a, face_a, FaceLink::boundary(ring_.patches[0]));
    } else if (OpenFaces& open = open_[u][v]; !open.waiting) {
      open = {FaceLink::to(made.b, face_b), FaceLink::to(made.a, face_a), true};
    } else {
      link_to(mesh_, made.b, face_b, open.b);
      link_to(mesh_, made.a, face_a, open.a);
    }
  }

  Builder& builder_;
  TetMesh& mesh_;
  const ShapeMeasure& measure_;
  const EdgeRing& ring_;
  int size_;
  std::array<Side, kMaxRing> behind_a_, behind_b_;
  std::array<std::array<OpenFaces, kMaxRing>, kMaxRing> open_;
};

/// Whether one of the edges that come to light is one already, elsewhere.
template <class Lock, class Triangles>
Joined makes_edge_twice(const TetMesh& mesh, const EdgeRing& ring, const Triangles& triangles, Lock& lock,
                        VertexBall& ball) {
  const int last = static_cast<int>(ring.rim.size()) - 1;
  const auto look = [&](int i, int k) {
    const bool is_old = k == i + 1 || (i == 0 && k == last && !ring.open);
    return is_old ? Joined::kNo : are_joined(mesh, VertexId(ring.rim[i]), VertexId(ring.rim[k]), lock, ball);
  };
  for (const Triangle& x : triangles)
    for (const auto& [i, k] : {std::pair{x.i, x.j}, {x.j, x.k}, {x.i, x.k}})
      if (const Joined joined = look(i, k); joined != Joined::kNo) return joined;
  return Joined::kNo;
}

/// True if both faces at the edge belong to one tetrahedron and one curved patch. What lies on both sides of
/// a smooth edge is flat, and may go.
bool is_flat_tet(const EdgeRing& ring, const PatchShapes& shapes) {
  return ring.tets.size() == 1 && ring.dimension() == VertexDimension::kSurface &&
         is_any_curved(ring.patches, shapes);
}

/// True if the edge may go: not one of a curve, nor between labels, nor of a frozen patch.
bool may_remove(const TetMesh& mesh, const EdgeRing& ring, const PatchShapes& shapes, int max_tets) {
  const std::size_t max_rim = static_cast<std::size_t>(std::min(max_tets, kMaxRing));
  if (ring.rim.size() < 3 || ring.rim.size() > max_rim) return false;
  if (ring.patch_faces == 0) return true;
  if (!ring.open || ring.dimension() != VertexDimension::kSurface) return false;
  const Label label = mesh.label(ring.tets[0]);
  return !is_any_frozen(ring.patches, shapes) &&
         std::ranges::all_of(ring.tets, [&](TetId t) { return mesh.label(t) == label; });
}

/// True if t can be taken away with two of its faces on the outside, those without c or without d, so that
/// the surface stays a manifold: the edge (c, d), which comes to light, lay in the volume until now.
bool leaves_manifold(const TetMesh& mesh, TetId t, VertexId a, VertexId b, const EdgeRing& ring_of_cd) {
  const auto may_come_to_light = [&](VertexId opposite) {
    const int face = mesh.index_of(t, opposite);
    return !mesh.link(t, face).is_boundary() && !mesh.interface_patch(t, face).valid();
  };
  return may_come_to_light(a) && may_come_to_light(b) && ring_of_cd.patch_faces == 0;
}

/// Takes a boundary sliver away, whose ring is gathered: t alone, with two faces on one curved patch at edge
/// (a, b).
Outcome remove_boundary_sliver(auto& site, TetId t, VertexId a, VertexId b) {
  TetMesh& mesh = site.mesh;
  EdgeRing& ring = site.scratch.ring;
  const PatchId patch = ring.patches[0];
  const VertexId c(ring.rim[0]), d(ring.rim[1]);
  if (!keeps_to_surface_across(mesh, ring, a, b, site.subject.shapes)) return Outcome::kRejected;
  if (!gather_ring(mesh, t, c, d, site.lock, ring)) return Outcome::kContended;
  if (!leaves_manifold(mesh, t, a, b, ring)) return Outcome::kRejected;

  for (const VertexId opposite : {a, b}) {
    const FaceLink behind = mesh.link(t, mesh.index_of(t, opposite));
    mesh.set_link(behind.tet(), behind.face(), FaceLink::boundary(patch));
    for (const std::uint32_t v : mesh.face_corners(behind.tet(), behind.face()))
      mesh.set_incident_tet(VertexId(v), behind.tet());
  }
  site.scratch.builder.note_change(mesh.tet(t));
  site.scratch.builder.free_tet(t);
  return Outcome::kApplied;
}

}  // namespace

Outcome EdgeRemoval::operator()(auto& site, const TetEdge& edge) const {
  const auto [a, b] = vertices_of(site.mesh, edge);
  const TetId t = edge.tet;
  TetMesh& mesh = site.mesh;
  EdgeRing& ring = site.scratch.ring;
  if (!gather_ring(mesh, t, a, b, site.lock, ring)) return Outcome::kContended;
  if (is_flat_tet(ring, site.subject.shapes)) return remove_boundary_sliver(site, t, a, b);
  if (!may_remove(mesh, ring, site.subject.shapes, rules.max_ring_tets)) return Outcome::kRejected;
  double worst = 1;
  for (const TetId x : ring.tets) worst = std::min<double>(worst, mesh.quality(x));
  const double min_quality = worst + rules.min_gain;
  RimTriangulation triangulation(mesh, site.subject.measure, ring, a, b);
  if (!triangulation.find(metric::cube(min_quality), rules.max_length) || !triangulation.is_positive() ||
      !keeps_to_surface_across(mesh, ring, a, b, site.subject.shapes))
    return Outcome::kRejected;
  const Joined joined = makes_edge_twice(mesh, ring, triangulation.triangles(), site.lock, site.scratch.ball);
  if (const auto refusal = refusal_of(joined)) return *refusal;
  RingReplacement(site.scratch.builder, site.subject.measure, ring, a, b).apply(triangulation);
  return Outcome::kApplied;
}

template struct OperatorCode<EdgeRemoval>;

}  // namespace lumesh::operators
