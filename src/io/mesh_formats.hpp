#pragma once
/// @file Readers and writers of the formats in the table of file_formats.cpp. All throw Error{kBadInput}.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "lumesh/core/context.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {
class LabelImage;
}

namespace lumesh::io {

/// In small letters; with what stands before it, if it is .gz.
[[nodiscard]] std::string lower_extension(const std::filesystem::path& path);

void write_vtu(const std::filesystem::path& path, const MeshView& mesh, const MeshWriteOptions& options);
void write_vtp_surface(const std::filesystem::path& path, const MeshView& mesh,
                       const MeshWriteOptions& options);
void write_legacy_vtk(const std::filesystem::path& path, const MeshView& mesh,
                      const MeshWriteOptions& options);
void write_medit_ascii(const std::filesystem::path& path, const MeshView& mesh);
void write_medit_binary(const std::filesystem::path& path, const MeshView& mesh);
void write_gmsh(const std::filesystem::path& path, const MeshView& mesh, MshVersion version);
/// Refuses a folder that has the mesh of another .foam file.
void write_foam(const std::filesystem::path& path, const MeshView& mesh);
/// The same before there is a mesh.
void check_foam_case(const std::filesystem::path& path);
void write_stl(const std::filesystem::path& path, const MeshView& mesh);
void write_off(const std::filesystem::path& path, const MeshView& mesh);
/// For FEniCS: NAME.xdmf with NAME.h5, NAME_facets.xdmf with NAME_facets.h5, NAME_tags.json. Tetrahedra only.
void write_xdmf(const std::filesystem::path& path, const MeshView& mesh);
/// A folder for svMultiPhysics; it replaces one that holds nothing else. Tetrahedra only.
void write_simvascular(const std::filesystem::path& path, const MeshView& mesh);
/// Whether the name ends in mesh-complete, with or without a slash behind.
[[nodiscard]] bool is_simvascular_folder(const std::filesystem::path& path);
/// Refuses to replace what is not a mesh alone.
void check_simvascular_folder(const std::filesystem::path& path);

[[nodiscard]] MixedMesh read_vtu(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_vtp_surface(const std::filesystem::path& path);
/// Patches by an array of cells of this name; if it is empty as read_vtp_surface(), with warnings of arrays
/// that patches could be by but for their numbers.
[[nodiscard]] MixedMesh read_vtp_surface_by(const std::filesystem::path& path, const std::string& patch_array,
                                            const Context& context);
[[nodiscard]] MixedMesh read_obj(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_off(const std::filesystem::path& path);
/// Unstructured grids, and PolyData with patches as of read_vtp_surface().
[[nodiscard]] MixedMesh read_legacy_vtk(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_legacy_vtk_by(const std::filesystem::path& path, const std::string& patch_array,
                                           const Context& context);
/// Stanford's polygons, text or binary; their points and faces alone.
[[nodiscard]] MixedMesh read_ply(const std::filesystem::path& path);
/// Points and info alone.
[[nodiscard]] MixedMesh read_vtk_xml_points(const std::filesystem::path& path, std::string_view dataset_type);
[[nodiscard]] MixedMesh read_legacy_vtk_points(const std::filesystem::path& path);
/// Arrays of one or three components.
[[nodiscard]] PointData read_vtk_xml_point_data(const std::filesystem::path& path,
                                                std::string_view dataset_type);
[[nodiscard]] PointData read_legacy_vtk_point_data(const std::filesystem::path& path);
/// One point a line; a table of named columns; see read_points() and read_point_data().
[[nodiscard]] MixedMesh read_text_points(const std::filesystem::path& path);
[[nodiscard]] PointData read_text_point_data(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_medit_ascii(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_medit_binary(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_gmsh(const std::filesystem::path& path);
[[nodiscard]] MixedMesh read_stl(const std::filesystem::path& path);

void write_nrrd(const std::filesystem::path& path, const LabelImage& image,
                const std::function<void()>& when_complete);
void write_nifti(const std::filesystem::path& path, const LabelImage& image,
                 const std::function<void()>& when_complete);

}  // namespace lumesh::io
