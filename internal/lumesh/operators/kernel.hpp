#pragma once
/// @file What runs the operators that change a mesh, the only code that does so concurrently: operators are
/// types (operators.hpp), which one apply() runs.
///
/// Each has one shape: with what it touches locked, check that it is still there, gather, evaluate without
/// changing anything, and commit, which cannot fail, or leave everything as it was. After each of them the
/// mesh is valid: every tetrahedron positively oriented by the exact predicate, conforming, labels and
/// patches kept. Vertices carry metrics (TetMesh::enable_metric()), and the stored quality of every
/// tetrahedron stays right.

#include <cstdint>
#include <memory>
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
  const InputSurface* surface = nullptr;  ///< Surface for VertexSliding; without it, no vertex slides.
};

/// Edge from one corner of a tetrahedron to another.
struct TetEdge {
  TetId tet;
  int from = 0, to = 1;
};

/// Face of a tetrahedron opposite a corner.
struct TetFace {
  TetId tet;
  int face = 0;
};

struct Scratch;

/// What operators work on and with: the mesh of the subject, and one thread's lock, counts and working
/// memory.
template <class Lock>
struct Site {
  const Subject& subject;
  TetMesh& mesh;
  Lock& lock;
  OperatorCounts& counts;
  Scratch& scratch;
};

/// An operator: its rules, where it is tried (Target: VertexId, TetId, TetEdge or TetFace) and what it does,
///     Outcome operator()(auto& site, const Target& target) const;
/// which is run with the vertices of the target held and asks site.lock for every other one. It is counted as
/// kId; one that has no kId only tries others, each of which is counted. With kMeasure it needs that measure
/// of the qualities; with would_fail(site, target) it is not tried, nor counted, where that is true.
template <class T>
concept Operator = std::default_initializable<T> && requires {
  typename T::Target;
};

/// True if the operator works with the measure.
template <Operator T>
[[nodiscard]] constexpr bool suits(ShapeMeasure::Kind kind) {
  if constexpr (requires { T::kMeasure; }) return kind == T::kMeasure;
  return true;
}

/// Code of an operator for every lock, from src/operators/apply.hpp; the operator's file makes an instance.
template <Operator T>
struct OperatorCode {
  using Target = typename T::Target;
  static Outcome apply(Site<NoLock>& site, const T& operation, const Target& target);
  static Outcome apply(Site<OrderedLock>& site, const T& operation, const Target& target);
  static Outcome apply(Site<SpeculativeLock>& site, const T& operation, const Target& target);
};

/// One thread's working memory and counts: make one per thread and keep it. Where others work on the mesh,
/// the tetrahedra of targets must be held (try_lock()).
template <class Lock>
class Kernel {
 public:
  /// New elements are taken from, and freed ones given to, `owner` of the mesh (TetMesh::set_owners()).
  explicit Kernel(const Subject& subject, Lock lock = {}, int owner = 0);

  /// Locks the target, runs the operator, counts the outcome and releases what was locked.
  template <Operator T>
  Outcome apply(const T& operation, const typename T::Target& target) {
    Site<Lock> site{subject_, subject_.mesh, lock_, counts_, *scratch_};
    return OperatorCode<T>::apply(site, operation, target);
  }

  [[nodiscard]] const OperatorCounts& counts() const { return counts_; }

  /// Begins a run: the lock to ask from now on, the stamp of new elements, and the epoch of changes.
  /// Forgets elements made before, and the edges that failed.
  void begin_run(const Lock& lock, std::uint32_t stamp, std::uint32_t epoch);
  /// Elements that this run made or changed, in this order; those freed again or remade have another stamp,
  /// and an element may stand here twice.
  [[nodiscard]] const std::vector<TetId>& made_tets() const;
  [[nodiscard]] const std::vector<VertexId>& made_vertices() const;
  /// True if all vertices of t could be locked: t does not change then. Where it was not held before, its
  /// stamp tells whether it still is the tetrahedron that was meant.
  [[nodiscard]] bool try_lock(TetId t);
  [[nodiscard]] bool try_lock(VertexId v) { return lock_.try_lock(v); }
  /// Releases all held vertices.
  void release() { lock_.release_to(0); }

 private:
  Subject subject_;
  Lock lock_;
  OperatorCounts counts_;
  std::shared_ptr<Scratch> scratch_;  // Never shared; a unique pointer would need the type here.
};

}  // namespace lumesh::operators
