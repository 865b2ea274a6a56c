#pragma once
/// @file The choice of the boundary: tetrahedra change their material until every label's boundary is a
/// manifold
// surface without exposed single tetrahedra and pits, so that it can be fitted to the image.

#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

struct BoundaryChoice {
  std::size_t relabelled = 0;
  /// Vertices that are not manifold in the end; 0 unless the image is degenerate at the lattice's scale.
  std::size_t non_manifold_vertices = 0;
};

/// Works on mesh.materials alone. A label's boundary is manifold when around every vertex both the label's
/// tetrahedra and the others are connected through faces.
BoundaryChoice choose_boundary(WorkMesh& mesh, const ImageDomain& domain);

}  // namespace lumesh::fitting
