#pragma once
/// @file Which vertices of a mesh are neighbours.

#include <cstdint>
#include <vector>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh {

/// The vertices that share an edge with each vertex, ascending. Parallel inside.
[[nodiscard]] inline parallel::Adjacency vertex_neighbours(const TetMesh& mesh) {
  const auto pairs =
      parallel::collect<std::uint64_t>(mesh.tet_slots(), [&](std::size_t i, std::vector<std::uint64_t>& out) {
        const TetId t(static_cast<std::uint32_t>(i));
        if (!mesh.alive(t)) return;
        for (const auto& [k, l] : kTetEdges)
          parallel::add_both_ways(mesh.vertex(t, k).value, mesh.vertex(t, l).value, out);
      });
  return parallel::adjacency_of(pairs, mesh.vertex_slots());
}

}  // namespace lumesh
