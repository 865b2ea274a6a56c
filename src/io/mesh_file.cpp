#include "lumesh/io/mesh_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/patch_names.hpp"
#include "lumesh/io/surface_file.hpp"
#include "lumesh/mesh/outer_faces.hpp"
#include "mesh_formats.hpp"
#include "part_names.hpp"
#include "utf8.hpp"

namespace lumesh {

void MeshWriteOptions::describe(OptionList& list) {
  list.choice("msh_version", msh_version, {{"4.1", MshVersion::k41}, {"2.2", MshVersion::k22}},
              "Version of a .msh file; MFEM and older programs want 2.2");
  list.choice("compat", compat,
              {{"none", LabelAlias::kNone},
               {"gmsh", LabelAlias::kGmsh},
               {"medit", LabelAlias::kMedit},
               {"simvascular", LabelAlias::kSimVascular}},
              "The label array once more, under the name that this program looks for")
      .of_files(FileUse::kLabelAlias);
}

namespace {

using Path = std::filesystem::path;

/// "2 prisms, 1 pyramid": cells that are no tetrahedra.
std::string other_shapes_of(const MeshView& mesh) {
  std::vector<std::string> shapes;
  const auto add = [&](std::size_t count, std::string_view one, std::string_view many) {
    if (count > 0) shapes.push_back(counted(count, one, many));
  };
  add(mesh.prisms.size(), "prism", "prisms");
  add(mesh.hexahedra.size(), "hexahedron", "hexahedra");
  add(mesh.pyramids.size(), "pyramid", "pyramids");
  return fmt::format("{}", fmt::join(shapes, ", "));
}

/// Prisms are layers; hexahedra come with pyramids, or are layers on quadrilaterals.
std::string remedy_of_shapes(const MeshView& mesh) {
  return mesh.hexahedra.empty() ? fmt::format("make the layers with {} tetrahedra", option_name("cells"))
                                : "mesh without hexahedra";
}

/// @throws Error{kBadInput} unless the mesh has tetrahedra, has no other cells nor faces than triangles, and
/// its numbers of points, cells and faces fit into 32 bits with sign, counted from 1.
void require_tetrahedra(const Path& path, const MeshView& mesh) {
  const std::size_t others = mesh.cell_count() - mesh.tetrahedra.size();
  if (others > 0)
    io::fail(path, fmt::format("holds tetrahedra only, and {} of the {} cells are of other shapes ({}); {}",
                               others, mesh.cell_count(), other_shapes_of(mesh), remedy_of_shapes(mesh)));
  if (mesh.tetrahedra.empty())
    io::fail(path, "holds tetrahedra, and the mesh has none; convert a volume mesh");
  if (!mesh.quadrilaterals.empty())
    io::fail(path, fmt::format("holds triangles only, and the boundary has {} quadrilaterals; remove them or "
                               "choose .vtu",
                               mesh.quadrilaterals.size()));
  constexpr std::size_t kMax = std::numeric_limits<std::int32_t>::max();
  if (mesh.points.size() > kMax || mesh.tetrahedra.size() > kMax || mesh.triangles.size() > kMax)
    io::fail(path, "numbers in 32 bits, too few for this mesh; choose .vtu");
}

}  // namespace

void write_mesh(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  const io::FileFormat& format = io::format_of(path, FileUse::kWrite);
  if (format.serves(FileUse::kWriteVolume) && !format.serves(FileUse::kWriteMixed))
    require_tetrahedra(path, mesh);
  if (is_boundary_alone(path)) return write_surface(path, mesh, options);
  format.code.write(path, mesh, options);
}

void write_surface(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  const io::FileFormat& format = io::format_of(path, FileUse::kWriteSurface);
  format.code.write(path, OuterFaces(mesh).view(), options);
}

MixedMesh read_mesh(const Path& path) {
  return read_surface_file(path, "", Context());
}

MixedMesh read_surface_file(const Path& path, const std::string& patch_array, const Context& context) {
  io::check_file(path);
  const io::FileFormat& format = io::format_of(path, FileUse::kRead);
  const bool has_arrays = format.serves(FileUse::kPatchArray);
  if (!patch_array.empty() && !has_arrays)
    io::fail(path, "has no arrays of cells; `patch_array` is for " + formats_for(FileUse::kPatchArray));
  MixedMesh mesh =
      has_arrays ? format.code.read_by_array(path, patch_array, context) : format.code.read(path);
  for (Patch& patch : mesh.info.patches) patch.name = io::as_utf8(std::move(patch.name));
  for (auto& [label, name] : mesh.info.label_names) name = io::as_utf8(std::move(name));
  // Formats in which each label must have a name have this one for those without.
  std::erase_if(mesh.info.label_names,
                [](const auto& named) { return named.second == fmt::format("label_{}", named.first); });
  if (format.parts.empty()) return mesh;
  const std::string renamed = io::name_patches_by_words(mesh.info.patches, format.parts);
  if (!renamed.empty()) context.warn(path.string() + ": " + renamed);
  return mesh;
}

bool is_mesh_folder(const Path& path) {
  return io::is_simvascular_folder(path);
}

void check_mesh_folder(const Path& path) {
  if (is_mesh_folder(path)) io::check_simvascular_folder(path);
  if (io::lower_extension(path) == ".foam") io::check_foam_case(path);
}

}  // namespace lumesh
