#pragma once
/// @file Conflict sets: the tetrahedra that a point would replace, for as long as nobody changes the mesh.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/local_map.hpp"
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
  LocalMap<std::uint32_t, char> known_;  // The same.
};

}  // namespace lumesh::delaunay
