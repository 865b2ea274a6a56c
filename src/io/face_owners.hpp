#pragma once
/// @file Which tetrahedra the triangles of the boundary belong to.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// The tetrahedron behind a triangle.
struct FaceOwner {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t cell = kNone;  ///< With two of them, that of the patch's first label, else the first.
  bool between = false;        ///< There is a tetrahedron on either side.
  Cell<3> outward = {};        ///< The triangle as it looks out of `cell`.
};

/// One owner per triangle of a mesh of tetrahedra, whichever way the triangles are turned. Threads: all, with
/// the same result for any number. Memory: about 100 bytes per tetrahedron.
[[nodiscard]] std::vector<FaceOwner> find_face_owners(const MeshView& mesh);

}  // namespace lumesh::io
