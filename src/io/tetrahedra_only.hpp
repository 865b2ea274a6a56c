#pragma once
/// @file Formats that hold tetrahedra and triangles, and nothing else.

#include <filesystem>
#include <string_view>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// @param reader  Who cannot read other cells, for the message.
/// @throws Error{kBadInput} unless the mesh has tetrahedra, has no other cells nor faces than triangles, and
/// its numbers of points, cells and faces fit into 32 bits with sign, counted from 1.
void require_tetrahedra(const std::filesystem::path& path, const MeshView& mesh, std::string_view reader);

}  // namespace lumesh::io
