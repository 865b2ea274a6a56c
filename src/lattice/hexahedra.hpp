#pragma once
// Hexahedra and pyramids instead of tetrahedra where the lattice is regular.

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Turns cubes of the lattice into hexahedra wherever a vertex inside one label still has the regular star of
/// 24 tetrahedra: the vertex goes, its eight nearest neighbours become the corners. Across each of the six
/// squares the four tetrahedra become one pyramid, or nothing if a hexahedron lies on the other side too. The
/// lattice consists of two interleaved grids; in each connected regular region the vertices of the grid that
/// makes more hexahedra go. Space that was filled stays filled, the mesh stays conforming, boundary
/// triangles stay.
///
/// @param mesh  Tetrahedra of a lattice, positively oriented; changed in place.
/// @param axes  Columns: directions of the lattice's long edges, orthonormal.
/// Threads: parallel inside; the same result for every thread count. Cost: linear.
/// Reference: the mixed meshes of doi:10.48550/arXiv.2402.18596.
void merge_hexahedra(MixedMesh& mesh, const Mat3& axes);

}  // namespace lumesh
