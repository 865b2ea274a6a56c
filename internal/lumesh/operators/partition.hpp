#pragma once
/// @file Buckets of vertices: the units of work of the ordered execution, and the reach of each.
///
/// A run of bucket b may change the tetrahedra whose vertices all lie in b and its neighbour buckets: its
/// reach. Buckets whose reaches meet are in conflict and run one after the other, in an order that depends on
/// the mesh alone. New vertices belong to the bucket that made them.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/ordered_tasks.hpp"

namespace lumesh::operators {

struct Partition {
  std::uint32_t buckets = 0;
  parallel::TaskGraph neighbours;  ///< Buckets that share a tetrahedron.
  parallel::TaskGraph conflicts;   ///< Buckets that share a neighbour or are neighbours.
};

/// Items per bucket, as vertices of a mesh: enough buckets for many threads, each worth its overhead. It must
/// not depend on the thread count, or results would.
[[nodiscard]] std::size_t bucket_size_for(std::size_t items);

/// Cuts the live vertices into buckets by bisection across the longest extent in the local metric, so that
/// buckets are round in the metric however stretched the elements are; the number of each vertex's bucket
/// goes into its lock word.
///
/// @param vertices  All live vertices, in an order that depends on the mesh alone.
/// @param tets      All live tetrahedra, in any order.
/// Parallel inside; the same for every thread count. Cost: about 0.3 s per million vertices on one core.
[[nodiscard]] Partition partition_vertices(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                           const std::vector<std::uint32_t>& tets, std::uint32_t bucket_size);

}  // namespace lumesh::operators
