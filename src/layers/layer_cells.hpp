#pragma once
/// @file Cells and faces of the layers over a surface, as a mesh together with what they stand on.

#include "columns.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh::layers {

/// The volume mesh that layers stand on, or hang from.
struct Footing {
  const TetMesh& mesh;
  const BoundaryFaces& faces;
  const Choice& choice;                        ///< Of its patches.
  const std::vector<std::uint32_t>& vertices;  ///< Of the mesh at each column: its lower end, or its upper
                                               ///< one where layers grow inwards.
};

/// The mesh with its layers. @param label  Of the layers.
[[nodiscard]] MixedMesh with_layers(const Footing& footing, const Growth& growth, const Columns& columns,
                                    const LayerOptions& options, Label label);

}  // namespace lumesh::layers
