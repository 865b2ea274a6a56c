#pragma once
/// @file Removal of tetrahedra beyond cut planes and outside the domain's bounds.

#include <cstddef>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Gives tetrahedra with a corner beyond a cut plane, or out of Domain::bounds_mm(), to the outside: they
/// became part of the object where pinched vertices were repaired. Vertices that this pinches are repaired in
/// turn, in the end by giving all around them to the outside: none is left. Labels of tetrahedra are
/// materials. @return Number of relabelled tetrahedra.
std::size_t relabel_out_of_bounds(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
