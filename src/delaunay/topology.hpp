#pragma once
/// @file Vertices where the boundary of a label is not a manifold.

#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Vertices around which the tetrahedra of a label, or those of all others, are not connected through faces;
/// every part of the outside is one. Labels of tetrahedra are materials. In the order of their places,
/// whatever their numbers are.
[[nodiscard]] std::vector<VertexId> pinched_vertices(const TetMesh& mesh, const Domain& domain);

/// Gives few tetrahedra around pinched vertices other materials until there are no such vertices.
/// @return how many.
std::size_t relabel_pinched(TetMesh& mesh, const Domain& domain);

}  // namespace lumesh::delaunay
