#pragma once
/// @file The volume mesh makes room for layers within it.

#include <vector>

#include "columns.hpp"

namespace lumesh::layers {

/// What is left of the volume between the layers' inner ends.
struct Core {
  TetMesh mesh;                         ///< Compact, valid.
  std::vector<std::uint32_t> vertices;  ///< Of each column's inner end.
  std::vector<double> reached;          ///< Share of each column's length that the mesh gave way by, 0 to 1.
};

/// Draws the surface of a mesh inwards along columns, step by step: the vertices behind follow, as far as
/// every tetrahedron stays positively oriented by the exact predicate, those of flat patches within them;
/// then edges that became short are collapsed, tetrahedra reconnected and vertices smoothed, to the sizes
/// that the mesh had before. The surface's triangles stay as they are, but for their places. Parallel inside,
/// the same bits for every number of threads.
[[nodiscard]] Core give_way(const TetMesh& mesh, const BoundaryFaces& faces, const Growth& growth,
                            const Columns& columns);

}  // namespace lumesh::layers
