#pragma once
/// @file Meshes from and to files; the format follows the file name's extension.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// Extra names for the label array, for programs that look for their own.
enum class LabelAlias : std::uint8_t {
  kNone,
  kGmsh,         ///< gmsh:physical, gmsh:geometrical
  kMedit,        ///< medit:ref
  kSimVascular,  ///< ModelRegionID, or ModelFaceID on surfaces (patch id + 1)
};

enum class MshVersion : std::uint8_t { k22, k41 };

struct MeshWriteOptions {
  LabelAlias compat = LabelAlias::kNone;     ///< VTU, VTP and VTK files only.
  MshVersion msh_version = MshVersion::k41;  ///< .msh files only.

  void describe(OptionList& list);
};

/// Writes a mesh in any format that README.md lists; surface formats get its boundary faces, .stl and
/// .off, which cannot tell patches apart, as write_surface() does. For solvers: .foam (an empty file, beside
/// it OpenFOAM's folder constant/polyMesh, ASCII, in metres); of tetrahedra only, .xdmf with the files beside
/// it that FEniCS reads, and SimVascular's folder under a name that ends in mesh-complete.
///
/// Cells carry their label, boundary faces their patch; docs/stages/convert.md says what each format holds.
/// A metric goes into .vtu and .vtk, as the point array `metric`; for Medit's files see metric_file.hpp.
/// The file is written beside the target and renamed when complete. Memory: a few MB, for VTU also one
/// compressed array, for XDMF twice its arrays, for OpenFOAM about 130 bytes per tetrahedron. Threads: all
/// for OpenFOAM, otherwise one; any number of calls at once, but one that writes XDMF.
/// @throws Error{kBadInput} if the extension is unknown, the format cannot hold the mesh, or writing fails
/// (no such folder, read-only, disk full); nothing is left behind then.
void write_mesh(const std::filesystem::path& path, const MeshView& mesh,
                const MeshWriteOptions& options = {});

/// Writes the outer boundary alone, with the points it uses, in a format for surfaces: the faces as in
/// `mesh`, without those between two of its cells, such as interfaces of labels; see extract_boundary() for
/// meshes without any. Errors as write_mesh(). Memory: also 8 bytes per point and 28 per face.
void write_surface(const std::filesystem::path& path, const MeshView& mesh,
                   const MeshWriteOptions& options = {});

/// Reads volumes and surfaces in every format that README.md lists.
///
/// Cells keep the order of the file, in VTK's vertex order. Labels come from `label` or another program's
/// array (docs/stages/convert.md); 1 if there is none. The metric is the point array `metric` of .vtu and
/// .vtk, every tensor finite and positive definite; empty if there is none. Sizes are their scalar point
/// array `size`. Every cell refers to existing points and all points are finite.
/// @throws Error{kBadInput} if the file is missing, broken, or holds cells lumesh does not know.
/// Memory: the file, and the mesh.
[[nodiscard]] MixedMesh read_mesh(const std::filesystem::path& path);

/// True for a file name that read_mesh() takes.
[[nodiscard]] bool is_mesh_file(const std::filesystem::path& path);
/// True for a file name under which write_mesh() makes a folder, and replaces one that holds a mesh.
[[nodiscard]] bool is_mesh_folder(const std::filesystem::path& path);
/// @throws Error{kBadInput} if write_mesh() would refuse to replace what is there: under the name of a folder
/// a file, or more than a mesh; beside a .foam file the mesh of another one.
void check_mesh_folder(const std::filesystem::path& path);

/// Cells whose volume is not positive in VTK's vertex order (hexahedra, prisms and pyramids by corner
/// tetrahedra).
[[nodiscard]] std::size_t count_inverted_cells(const MeshView& mesh);

/// Replaces the boundary faces by those found from the cells: one patch per pair of labels, named "wall" or
/// "wall_<label>" against the outside and "interface_<a>_<b>" between labels.
void extract_boundary(MixedMesh& mesh);

}  // namespace lumesh
