#pragma once
/// @file Checks of a part of a mesh that a thread holds, for paranoid builds.

#include <span>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Whether those of the tetrahedra that are alive are positive by the exact predicate, have live vertices
/// whose incident tetrahedra contain them, and neighbours behind all faces that name them and their three
/// vertices. All vertices must be held.
[[nodiscard]] bool are_sound(const TetMesh& mesh, std::span<const TetId> tets);

/// The same for all tetrahedra around a vertex and the faces at it; true if the vertex is freed. It must be
/// held.
[[nodiscard]] bool is_sound_around(const TetMesh& mesh, VertexId v);

}  // namespace lumesh::operators
