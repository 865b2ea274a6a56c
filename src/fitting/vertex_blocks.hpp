#pragma once
// Blocks of vertices that move at the same time.

#include <array>
#include <vector>

#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

/// Vertices in cubes of space, each of which fits into a processor's cache. Those of one block move one after
/// another, blocks of one class at the same time: between two of these lies a whole block, so that no
/// tetrahedron reaches from one to the other.
struct VertexBlocks {
  static constexpr std::size_t kClasses = 8;  ///< By even or odd indices along the axes.
  using Block = std::vector<std::uint32_t>;   ///< Ascends.
  std::array<std::vector<Block>, kClasses> classes;

  bool operator==(const VertexBlocks&) const = default;
};

/// Boundary vertices and three rings of others behind them, ascending.
[[nodiscard]] std::vector<std::uint32_t> vertices_near_boundary(const WorkMesh& mesh,
                                                                const BoundaryModel& boundary);

/// Splits the vertices into blocks. Deterministic.
[[nodiscard]] VertexBlocks make_vertex_blocks(const WorkMesh& mesh,
                                              const std::vector<std::uint32_t>& vertices);

/// The blocks' vertices that `chosen` accepts.
template <class Chosen>
[[nodiscard]] VertexBlocks pick_vertices(const VertexBlocks& blocks, const Chosen& chosen) {
  VertexBlocks picked;
  for (std::size_t c = 0; c < VertexBlocks::kClasses; ++c) {
    picked.classes[c] = parallel::collect<VertexBlocks::Block>(
        blocks.classes[c].size(), 64, [&](std::size_t b, std::vector<VertexBlocks::Block>& out) {
          VertexBlocks::Block part;
          for (const std::uint32_t v : blocks.classes[c][b]) {
            if (chosen(v)) part.push_back(v);
          }
          if (!part.empty()) out.push_back(std::move(part));
        });
  }
  return picked;
}

/// Follows a mesh that has lost tetrahedra: `kept` are the old numbers of its vertices, ascending.
void keep_vertices(VertexBlocks& blocks, const std::vector<std::uint32_t>& kept);

}  // namespace lumesh::fitting
