#pragma once
/// @file Exterior removal: from a triangulation of materials to the mesh of those that are meshed.

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Frees all but the tetrahedra of meshed materials, gives the faces between materials their patches and
/// tetrahedra their labels. The mesh is in the order of the curve afterwards.
void remove_exterior(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
