#pragma once
/// @file The choice of the boundary: tetrahedra change their material until every label's boundary is a
/// manifold surface without exposed single tetrahedra and pits, so that it can be fitted to the image.

#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

/// Works on mesh.materials alone. A label's boundary is manifold when around every vertex both the label's
/// tetrahedra and the others are connected through faces.
/// @return How often a tetrahedron has been relabelled.
std::size_t choose_boundary(WorkMesh& mesh, const ImageDomain& domain);

}  // namespace lumesh::fitting
