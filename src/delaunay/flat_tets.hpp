#pragma once
/// @file Flat tetrahedra on interfaces, where curves keep improvement from moving anything.

#include <cstddef>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// In domains of several labels, gives tetrahedra at curves that lie flat, with two faces, on the boundary to
/// another material to that material, as long as this pinches no vertex and leaves no worse boundary faces
/// than there were, or good ones. Cut planes stay as they are. One after another, in the order of their
/// places: they are few. Labels of tetrahedra are materials. @return Number of relabelled tetrahedra.
std::size_t relabel_flat(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
