#pragma once
/// @file How the vertices and faces of each patch may change.

#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

enum class PatchFreedom : std::uint8_t {
  kFrozen,  ///< Its faces, edges and vertices stay as they are.
  kPlane,   ///< A part of a plane: vertices may move, come and go within it.
};

struct PatchShape {
  PatchFreedom freedom = PatchFreedom::kFrozen;
  Vec3 normal = Vec3::Zero();  ///< Of a plane; unit length.
};

/// One shape per patch of the mesh.
using PatchShapes = std::vector<PatchShape>;

/// A plane for every patch whose faces lie in one to within `tolerance` times the size of the mesh's box; the
/// others are frozen. Where every face lies along a coordinate plane, the normal is exactly an axis.
[[nodiscard]] PatchShapes planes_where_flat(const TetMesh& mesh, double tolerance = 1e-10);

/// All patches frozen.
[[nodiscard]] PatchShapes all_frozen(const TetMesh& mesh);

}  // namespace lumesh::operators
