#pragma once
/// @file Cells of other shapes as tetrahedra, for what only looks at a mesh through its tetrahedra.

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// The same points, labels and triangles, with every pyramid, prism and hexahedron split into tetrahedra
/// between its own corners; those of the mesh come first, in its order. A quadrilateral is cut from its
/// lowest-numbered corner, so that both its cells agree, and a cell is the cone from its lowest corner to the
/// triangles that do not touch it: Dompierre, Labbé, Vallet and Camarero 1999, "How to subdivide pyramids,
/// prisms and hexahedra into tetrahedra". Flat or turned tetrahedra come of warped cells only.
/// @param mesh  Without quadrilaterals of patches.
[[nodiscard]] MixedMesh split_into_tetrahedra(const MeshView& mesh);

}  // namespace lumesh
