#pragma once
/// @file Insertion and removal of vertices of Delaunay triangulations.
///
/// The triangulation is that of insphere_perturbed(): every set of points has one and only one, so the result
/// does not depend on the order of insertions and removals, nor on the number of threads that made them.

#include <cstdint>
#include <memory>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/locks.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// One tetrahedron around the ball of centre and radius, with three times its size to spare: the hull of a
/// triangulation of points in the ball. Its vertices are 0 to 3, corners that stay; the label is the
/// background.
[[nodiscard]] TetMesh triangulation_around(const Vec3& centre, double radius);

struct DelaunayScratch;

/// Insertion and removal with one thread's working memory: make one per thread and keep it. Where others work
/// on the mesh, each has a lock of its own. New tetrahedra have the label of the background.
template <class Lock>
class DelaunayKernel {
 public:
  /// New elements are taken from, and freed ones given to, `owner` of the mesh (TetMesh::set_owners()).
  explicit DelaunayKernel(TetMesh& mesh, Lock lock = {}, int owner = 0);
  DelaunayKernel(DelaunayKernel&&) noexcept;
  ~DelaunayKernel();

  /// Sets the stamp of all elements made from now on.
  void begin_run(std::uint32_t stamp) { stamp_ = stamp; }

  struct Insertion {
    Outcome outcome = Outcome::kContended;
    VertexId vertex;  ///< The new one; where a vertex has the same place (kRejected), that one.
  };
  /// Inserts a vertex: the tetrahedra whose circumsphere holds it are replaced by those from their hull to
  /// it.
  /// @param point  Inside the hull.
  /// @param near   A live vertex to begin the search from; best one near the point.
  /// Cost: about 3 us where `near` is near. Source: Bowyer 1981, doi:10.1093/comjnl/24.2.162; Watson 1981,
  /// doi:10.1093/comjnl/24.2.167.
  [[nodiscard]] Insertion insert(const Vec3& point, VertexDimension dimension, VertexId near);

  /// Removes a live vertex, not one of the hull: the cavity is filled by the Delaunay tetrahedra of the
  /// vertices around it, face by face. Cost: about 30 us.
  [[nodiscard]] Outcome remove(VertexId v);

  /// The live tetrahedron that holds a point, or an invalid one if a vertex on the way could not be locked.
  /// Vertices locked on the way are held until release().
  [[nodiscard]] TetId locate(const Vec3& point, VertexId near);
  void release() { lock_.release_to(0); }

 private:
  [[nodiscard]] bool hold_tet(TetId t);
  [[nodiscard]] int face_towards(TetId t, const Vec3& point, int first) const;
  [[nodiscard]] bool gather_conflicts(TetId first, const Vec3& point);
  void restore_conflicts();
  [[nodiscard]] TetId make_tet(const Cell<4>& corners, std::size_t i);
  [[nodiscard]] VertexId fill_hole(const Vec3& point, VertexDimension dimension);
  [[nodiscard]] bool gather_star(VertexId v);
  void wrap_hole();
  void replace_star(VertexId v);

  TetMesh* mesh_;
  Lock lock_;
  int owner_;
  std::uint32_t stamp_ = 0;
  std::unique_ptr<DelaunayScratch> scratch_;
};

extern template class DelaunayKernel<NoLock>;
extern template class DelaunayKernel<SpeculativeLock>;

}  // namespace lumesh::operators
