#pragma once
/// @file The operators that change a mesh: the only code that does so concurrently.
///
/// Each has one shape: lock what it touches, check that it is still there, gather, evaluate without changing
/// anything, and commit, which cannot fail, or leave everything as it was. After each of them the mesh is
/// valid: every tetrahedron positively oriented by the exact predicate, conforming, labels and patches kept.
/// Vertices carry metrics (TetMesh::enable_metric()), and the stored quality of every tetrahedron stays
/// right.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/input_surface.hpp"
#include "lumesh/operators/locks.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/rules.hpp"
#include "lumesh/operators/shape_measure.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// Mesh, metric and shapes that operators work on. All of it outlives them.
struct Subject {
  TetMesh& mesh;                          ///< With metrics.
  const metric::MetricField& field;       ///< Gives new and moved vertices their metric.
  const PatchShapes& shapes;              ///< One per patch.
  ShapeMeasure measure = {};              ///< Measure of the stored quality of every tetrahedron.
  const InputSurface* surface = nullptr;  ///< Surface for slide_vertex(); without it, no vertex slides.
};

/// False if operators failed on t before, and nothing has changed since around at least `min_vertices` of its
/// vertices. One is enough for operators that look at all tetrahedra around a vertex. Two are asked for
/// reconnect(), which for the most part looks at tetrahedra that share an edge with t, and a change is noted
/// at all vertices of a tetrahedron: this sees more than the paper's test of face neighbours (its algorithm
/// 2), but not faces farther off that multi-face removal would add.
[[nodiscard]] bool has_changed_since_trial(const TetMesh& mesh, TetId t, int min_vertices = 1);
inline constexpr int kVerticesOfAnEdge = 2;

struct NewVertex;

/// One thread's operators with their working memory: make one per thread and keep it. Where others work on
/// the mesh, the tetrahedra that it is given must be held (try_lock()).
template <class Lock>
class Operators {
 public:
  /// New elements are taken from, and freed ones given to, `owner` of the mesh (TetMesh::set_owners()).
  explicit Operators(const Subject& subject, Lock lock = {}, int owner = 0);
  Operators(Operators&&) noexcept = default;

  /// Inserts a vertex on edge (corner i, corner j) of t, `fraction` of its metric length from i, into the
  /// cavity of all tetrahedra whose circumsphere in the new vertex's metric holds it (insphere test,
  /// corrected until the cavity is star-shaped). Inner vertices that encroach on a new vertex of a surface
  /// are collapsed onto it afterwards. An edge where it failed since begin_run() is not tried again, nor
  /// counted, before both ends saw a change. Sources: Loseille and Alauzet 2009,
  /// doi:10.1007/978-3-642-04319-2_33; Borouchaki, George et al. 1997, doi:10.1016/S0168-874X(96)00057-1.
  Outcome split_edge(TetId t, int i, int j, double fraction, const InsertionRules& rules);

  /// Inserts a vertex at the centroid of t, with the same kind of cavity.
  Outcome insert_centroid(TetId t, const InsertionRules& rules);

  /// Collapses corner `from` of t onto corner `to`: the tetrahedra around the edge vanish. A vertex of a
  /// curve stays on it, one of a surface on its patch, corners stay.
  Outcome collapse_edge(TetId t, int from, int to, const CollapseRules& rules);
  /// Collapses v onto its nearest admissible neighbour, of those at less than `min_length`.
  Outcome collapse_vertex(VertexId v, double min_length, const CollapseRules& rules);

  /// Collapses v onto its nearest admissible neighbour, with an approximate metric, that of v alone: for
  /// sweeps in which most vertices go. Vertices that others were collapsed onto stay, so that the rest lies
  /// evenly. The stored qualities are those of that metric: measure_qualities() afterwards. Vertices of
  /// curved patches stay.
  /// @param kept  One per vertex, 0 at the start of a sweep; 1 for vertices that others were collapsed onto,
  /// which stay.
  Outcome thin_out(VertexId v, std::span<std::uint8_t> kept, const ThinningRules& rules);

  /// Replaces the tetrahedra around edge (corner i, corner j) of t by the best ones without it: of all
  /// triangulations of the ring, the one with the best worst quality (dynamic programming). Covers 3-2, 4-4
  /// and larger rings, and 2-2 where the edge lies on a patch. A tetrahedron with two faces on one curved
  /// patch is flat: it is taken away. Source: Shewchuk 2002, Two discrete optimization algorithms for the
  /// topological improvement of tetrahedral meshes, "edge removal" (a manuscript without a DOI; used and
  /// described by Klingner and Shewchuk 2007, doi:10.1007/978-3-540-75103-8_1).
  Outcome remove_edge(TetId t, int i, int j, const SwapRules& rules);

  /// Replaces t and its neighbour behind `face` by three tetrahedra around a new edge (2-3); where these
  /// are not admissible, with the tetrahedra at faces next to it that lie between the same two vertices
  /// (multi-face removal: 4-4, 6-5 and on, the inverse of edge removal). Every new one is better than the
  /// worse of t and its neighbour. Source: Shewchuk 2002, "multi-face removal"; see remove_edge().
  Outcome remove_face(TetId t, int face, const SwapRules& rules);

  /// Moves a vertex to lessen the sum of 1 / quality around it plus that of its edges' deviation from unit
  /// length: one Newton step with backtracking. No tetrahedron falls below the worst one before or
  /// rules.quality_floor, whichever is less. Vertices of patches stay on them.
  Outcome smooth_vertex(VertexId v, const SmoothingRules& rules);

  /// Moves a vertex to where the worst dihedral angle around it is best (non-smooth optimisation). Vertices
  /// of patches stay. Measure: dihedral angles.
  Outcome optimise_vertex(VertexId v, const AngleRules& rules);

  /// As optimise_vertex(), for a vertex inside a patch: it moves along Subject::surface, and only where the
  /// faces around it stay near that surface and near the vertex's old place.
  Outcome slide_vertex(VertexId v, const AngleRules& rules);

  /// Inserts a vertex near t, in the best of several cavities, at the place where the worst dihedral angle of
  /// the new tetrahedra is best; only if that is better than the worst one before. The cavities are the
  /// tetrahedra around t or one of its edges on the same side of all patches, with and without the neighbours
  /// whose circumsphere holds the middle. Measure: dihedral angles. Source: Klingner and Shewchuk 2007,
  /// doi:10.1007/978-3-540-75103-8_1.
  Outcome insert_for_angles(TetId t, const AngleRules& rules);

  [[nodiscard]] const OperatorCounts& counts() const { return counts_; }

  /// Begins a run: the lock to ask from now on, the stamp of new elements, and the epoch of changes.
  /// Forgets elements made before, and the edges that failed.
  void begin_run(const Lock& lock, std::uint32_t stamp, std::uint32_t epoch);
  /// Elements that this run made or changed, in this order; those freed again or remade have another stamp,
  /// and an element may stand here twice.
  [[nodiscard]] const std::vector<TetId>& made_tets() const;
  [[nodiscard]] const std::vector<VertexId>& made_vertices() const;
  /// Tries edge removal on every edge of t, then removal of every face, until one is done; unless
  /// rules.repeat, not those that failed since begin_run() and saw no change. Where all were rejected, the
  /// epoch is noted on t: as long as nothing changes around its edges, another trial is hardly worth it
  /// (has_changed_since_trial()).
  Outcome reconnect(TetId t, const SwapRules& rules);
  /// True if all vertices of t could be locked: t does not change then. Where it was not held before, its
  /// stamp tells whether it still is the tetrahedron that was meant.
  [[nodiscard]] bool try_lock(TetId t);
  [[nodiscard]] bool try_lock(VertexId v) { return lock_.try_lock(v); }
  /// Releases all held vertices.
  void release() { lock_.release_to(0); }

 private:
  struct Scratch;

  /// Runs an operator with both vertices held, frees all locks and counts the outcome.
  template <class Body>
  Outcome on_held(OperatorCount& count, VertexId a, VertexId b, const Body& body);

  Outcome split_held_edge(TetId t, VertexId a, VertexId b, double fraction, const InsertionRules& rules);
  Outcome insert_in_hole(const NewVertex& vertex, std::span<const TetId> around, const InsertionRules& rules);
  Outcome collapse_gathered_vertex(VertexId v, const CollapseRules& rules);
  void commit_collapse(VertexId from, VertexId to);
  Outcome remove_held_edge(TetId t, VertexId a, VertexId b, const SwapRules& rules);
  Outcome remove_held_boundary_sliver(TetId t, VertexId a, VertexId b);
  Outcome remove_held_face(TetId t, int face, const SwapRules& rules);
  Outcome smooth_held_vertex(VertexId v, const SmoothingRules& rules);
  Outcome optimise_held_vertex(VertexId v, const AngleRules& rules);
  Outcome slide_held_vertex(VertexId v, const AngleRules& rules);
  double gather_angles(VertexId v);
  bool move_in_angles(VertexId v, const Vec3& to, const AngleRules& rules);
  Outcome insert_near_held_tet(TetId t, const AngleRules& rules);
  double prepare_hole(TetId t, int hole, const AngleRules& rules, Vec3& place);
  void draw_in_near_vertices(VertexId into);
  bool move_if_better(VertexId v, const Vec3& to, double below, double floor, const SmoothingRules& rules);

  Subject subject_;
  Lock lock_;
  OperatorCounts counts_;
  std::shared_ptr<Scratch> scratch_;  // Never shared; a unique pointer would need the type here.
};

}  // namespace lumesh::operators
