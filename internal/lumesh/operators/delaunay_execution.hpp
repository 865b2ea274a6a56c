#pragma once
/// @file Insertion and removal of many vertices of a Delaunay triangulation on many threads.
///
/// Each thread holds the vertices that it touches, as in SpeculativeExecution. Since the triangulation is
/// unique (delaunay_kernel.hpp), it is the same for every thread count and every order; the numbers of
/// its elements are not, before TetMesh::reorder_along_curve().

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::operators {

class DelaunayExecution {
 public:
  /// @param mesh  A Delaunay triangulation, such as triangulation_around().
  DelaunayExecution(TetMesh& mesh, const parallel::TeamOptions& team);

  struct NewVertex {
    Vec3 point;
    VertexDimension dimension = VertexDimension::kVolume;
    VertexId near;  ///< A live vertex near by, or invalid: then those before it in the list should be near.
  };
  /// Inserts all points, in rounds that grow, each along the Hilbert curve. Points at the place of a vertex
  /// are left out. All new elements get the stamp.
  /// @param vertices  For each point, the vertex at its place; empty if nobody asks.
  /// Cost: about 4 us each on one thread. Source: Amenta, Choi and Rote 2003, Incremental constructions con
  /// BRIO, doi:10.1145/777792.777824.
  void insert(std::span<const NewVertex> points, std::uint32_t stamp, std::span<VertexId> vertices = {});

  /// Removes live vertices, each named once, none of the hull.
  void remove(std::span<const VertexId> vertices, std::uint32_t stamp);

  [[nodiscard]] const parallel::Team& team() const { return team_; }

 private:
  template <class Lock>
  void insert_in_order(std::vector<DelaunayKernel<Lock>>& kernels, std::span<const NewVertex> points,
                       std::span<const std::uint32_t> order, std::uint32_t stamp,
                       std::span<VertexId> vertices);
  template <class Lock, class Attempt>
  void run_buckets(std::vector<DelaunayKernel<Lock>>& kernels, std::vector<std::uint32_t>& items,
                   std::uint32_t stamp, const Attempt& attempt);
  [[nodiscard]] std::uint32_t& known_near(const Vec3& point);

  TetMesh& mesh_;
  parallel::Team team_;
  std::vector<DelaunayKernel<NoLock>> alone_;             // One, if there is one thread.
  std::vector<DelaunayKernel<SpeculativeLock>> kernels_;  // Else one per thread.
  Box3 box_;                                              // Box of a grid of vertices to begin searches from.
  std::vector<std::uint32_t> known_;                      // A vertex per cell of that grid, or none.
};

}  // namespace lumesh::operators
