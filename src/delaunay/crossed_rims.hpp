#pragma once
/// @file Boundary faces that cut the edge of an object off, where two of its boundaries meet at an acute
/// angle.

#include <cstddef>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Near an opening that slants, or whose points stand far apart, the centre of a tetrahedron's circumsphere
/// may lie beyond the cut plane although the tetrahedron does not: such tetrahedra take the material at their
/// own centre, if that is meshed, as long as this pinches no vertex. Labels of tetrahedra are materials.
/// @return Number of relabelled tetrahedra.
std::size_t relabel_at_cuts(TetMesh& mesh, const Domain& domain);

/// A face between the object and the outside whose corners lie on no common boundary, such as one on the wall
/// and one on an opening, cuts off the edge between the two. Where these meet at an acute angle, the centre
/// of a tetrahedron's circumsphere does not say what the tetrahedron is: that of one inside of such a wedge
/// lies outside. There, those with all corners on the boundary take the material at their own centre, as long
/// as this pinches no vertex. One after another, in the order of their places: they are few. Labels of
/// tetrahedra are materials. @return Number of relabelled tetrahedra.
std::size_t relabel_crossed_rims(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
