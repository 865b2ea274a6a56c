#pragma once
/// @file Cells and faces of the layers over a surface, as one mesh together with the volume mesh.

#include <functional>

#include "columns.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh::layers {

/// The metric of a point: a vertex of the mesh, or one of layers and the mesh's vertex at its column.
using MetricAtFoot = std::function<SymTensor(const Vec3& point, VertexId foot)>;

/// The volume mesh that layers stand on, or hang from.
struct Footing {
  const TetMesh& mesh;
  const BoundaryFaces& faces;
  const PatchSelection& selection;             ///< Selection of the mesh's patches.
  const std::vector<std::uint32_t>& vertices;  ///< Vertex of the mesh at each column: its lower end, or its
                                               ///< upper one where layers grow inwards.
  MetricAtFoot metric;                         ///< None where the mesh has none.
};

/// The mesh with its layers.
[[nodiscard]] MixedMesh with_layers(const Footing& footing, const ExtrusionFrame& frame,
                                    const Columns& columns, const LayerOptions& options);

}  // namespace lumesh::layers
