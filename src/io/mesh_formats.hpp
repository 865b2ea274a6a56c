#pragma once
/// @file The formats behind write_mesh() and read_mesh(). All throw Error{kBadInput}.

#include <filesystem>

#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

void write_vtu(const std::filesystem::path& path, const MeshView& mesh, const MeshWriteOptions& options);
void write_vtp_surface(const std::filesystem::path& path, const MeshView& mesh,
                       const MeshWriteOptions& options);
void write_legacy_vtk(const std::filesystem::path& path, const MeshView& mesh,
                      const MeshWriteOptions& options);
void write_medit_ascii(const std::filesystem::path& path, const MeshView& mesh);
void write_medit_binary(const std::filesystem::path& path, const MeshView& mesh);
void write_gmsh(const std::filesystem::path& path, const MeshView& mesh, MshVersion version);
void write_stl(const std::filesystem::path& path, const MeshView& mesh);

[[nodiscard]] MixedMesh read_vtu(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_vtp_surface(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_legacy_vtk(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_medit_ascii(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_medit_binary(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_gmsh(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_stl(const std::filesystem::path& path);

}  // namespace lumesh::io
