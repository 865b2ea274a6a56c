#pragma once
/// @file Cells and faces of the layers over a surface, as a mesh together with what they stand on.

#include "columns.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh::layers {

/// The mesh with its layers. @param label  Of the layers.
[[nodiscard]] MixedMesh with_layers(const TetMesh& mesh, const BoundaryFaces& faces,
                                    const std::vector<std::uint8_t>& layered, const Growth& growth,
                                    const Columns& columns, const LayerOptions& options, Label label);

}  // namespace lumesh::layers
