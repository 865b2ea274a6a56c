#pragma once
/// @file Conflict sets: the tetrahedra that a point would replace, for as long as nobody changes the mesh.

#include <cstdint>
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
  void take_in(TetId t);
  [[nodiscard]] std::size_t slot_of(TetId t) const;

  std::vector<TetId> tets_;
  std::vector<std::uint32_t>
      table_;  // The elements of tets_, by open addressing; its size is a power of two.
};

}  // namespace lumesh::delaunay
