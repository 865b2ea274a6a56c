#pragma once
/// @file Which vertices of a mesh are neighbours.

#include <cstdint>
#include <vector>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh {

/// The vertices that share an edge with each vertex, ascending. Parallel inside.
[[nodiscard]] inline parallel::Adjacency vertex_neighbours(const TetMesh& mesh) {
  const auto pairs = collect_from_tets<std::uint64_t>(mesh, [&](TetId t, std::vector<std::uint64_t>& out) {
    for (const auto& [k, l] : kTetEdges)
      parallel::add_both_ways(mesh.vertex(t, k).value, mesh.vertex(t, l).value, out);
  });
  return parallel::adjacency_of(pairs, mesh.vertex_slots());
}

}  // namespace lumesh
