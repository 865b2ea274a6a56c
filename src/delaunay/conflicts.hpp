#pragma once
/// @file Which tetrahedra a point would replace, for as long as nobody changes the mesh.

#include <span>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Keep one per thread and use it again.
class ConflictFinder {
 public:
  /// The tetrahedra whose circumsphere holds a point inside the hull. Good until the next call.
  /// @param near  A live tetrahedron to begin the search from.
  std::span<const TetId> find(const TetMesh& mesh, const Vec3& point, TetId near);

 private:
  std::vector<TetId> tets_;
};

}  // namespace lumesh::delaunay
