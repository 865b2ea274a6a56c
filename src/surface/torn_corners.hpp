#pragma once
// Corners that triangles should share, but have each for itself at almost one place.

#include <string>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// How far apart such corners are where join_torn_corners() joins none, to within a factor of two; 0 where
/// that is not what ails the surface. @param welded  As of weld().
[[nodiscard]] double gap_of_torn_corners(const TriangleMesh& welded);
/// Words on such a gap, and what to do about it.
[[nodiscard]] std::string torn_corners_text(double gap_mm);
[[nodiscard]] std::string torn_corners_remedy(double gap_mm);

}  // namespace lumesh::surfaces
