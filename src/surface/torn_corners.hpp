#pragma once
// Corners that triangles should share, but have each for itself at almost one place.

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// How far apart such corners are where join_torn_corners() joins none, to within a factor of two; 0 where
/// that is not what ails the surface. @param welded  As of weld().
[[nodiscard]] double gap_of_torn_corners(const TriangleMesh& welded);

}  // namespace lumesh::surfaces
