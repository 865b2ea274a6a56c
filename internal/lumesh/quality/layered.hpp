#pragma once
/// @file A mesh with boundary layers, its two parts apart: cells of layers are flat by design, and would hide
/// how good the others are.

#include <cstdint>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"

namespace lumesh::quality {

/// Views of the two parts; their points are those of the whole mesh, their faces none.
struct LayeredParts {
  MeshView core;    ///< The cells that the layers stand on or lie around.
  MeshView layers;  ///< Their own cells.
};

/// How many cells the parts have; hexahedra are all of the core.
struct LayeredCells {
  std::uint64_t layers = 0, core_pyramids = 0, core_prisms = 0;
};

/// @param mesh  As layers are grown on it: their cells are the last of each shape.
[[nodiscard]] LayeredParts parts_of(const MeshView& mesh, const LayeredCells& cells);

/// Heights are those of a tetrahedron or pyramid over its largest face, of a prism its volume through the
/// mean area of its triangles. Hexahedra are left out. Threads: parallel inside, bitwise identical for every
/// thread count.
[[nodiscard]] FlatCellShapes measure_flat_cells(const MeshView& mesh);

}  // namespace lumesh::quality
