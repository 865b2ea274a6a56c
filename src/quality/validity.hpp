#pragma once
/// @file What is wrong with a mesh, in the words of its evaluation.

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// Beyond every body, whatever the unit: volumes and angles are hardly numbers there.
inline constexpr double kFarthest = 1e12;
/// Also false where a coordinate is no number.
[[nodiscard]] inline bool is_place(const Vec3& point) {
  return point.cwiseAbs().maxCoeff() <= kFarthest && point.allFinite();
}

/// Fills in the problems of the mesh: by validate() for tetrahedra, by volumes and faces for mixed cells.
void find_problems(const MeshView& mesh, const TetMesh* kernel, const MeshSurface& surface,
                   Evaluation& evaluation);

}  // namespace lumesh::quality
