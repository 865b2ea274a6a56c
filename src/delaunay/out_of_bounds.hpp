#pragma once
/// @file Nothing of the object lies beyond what cuts it off, or where there is none of it.

#include <cstddef>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Gives tetrahedra with a corner beyond a cut plane, or out of Domain::bounds_mm(), to the outside: they
/// became part of the object where pinched vertices were mended. What that pinches is mended in turn, eight
/// times at most. Labels of tetrahedra are materials. @return how many.
std::size_t relabel_out_of_bounds(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
