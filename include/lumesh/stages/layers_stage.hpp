#pragma once
/// @file Boundary layers on meshes of every shape of cell, for every front end.

#include <string>

#include "lumesh/domain/extension.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh {

/// As grow_layers(). Outwards the mesh may have hexahedra, pyramids and prisms, which stay as they are:
/// layers see its triangles and its volume alone. @param name  Of the mesh, for messages.
/// @throws what grow_layers() and tetrahedra_of() throw, and Error{kBadInput} for such cells inwards, for
/// quadrilaterals on the boundary, and for cells so warped that they cannot be split into tetrahedra.
[[nodiscard]] LayerResult grow_layers_on(const MixedMesh& mesh, const std::string& name,
                                         const LayerOptions& options, Context& context);

/// Sweeps the openings of a mesh on, as extrude_openings(), in place; warns of those that are not as asked
/// for. Nothing where no extension is wanted.
void extend_mesh(MixedMesh& mesh, const std::string& name, const ExtensionOptions& extension,
                 LayerCells cells, Context& context);

}  // namespace lumesh
