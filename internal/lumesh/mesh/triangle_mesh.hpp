#pragma once
/// @file A surface of triangles, and the outside of a mesh.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// A triangle surface that owns its arrays.
struct TriangleMesh {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;     ///< Anticlockwise seen from outside.
  std::vector<std::int32_t> patches;  ///< One per triangle; index into the patches of the mesh it came from.
};

/// The outside of the mesh. Points keep the order they have in the mesh. Parallel inside; the same for every
/// thread count.
[[nodiscard]] TriangleMesh extract_boundary(const TetMesh& mesh);

}  // namespace lumesh
