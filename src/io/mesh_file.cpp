#include "lumesh/io/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/io/surface_file.hpp"
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
              "The label array once more, under the name that this program looks for; .vtu, .vtk, .vtp only");
}

std::string io::lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  if (extension == ".gz") extension = path.stem().extension().string() + extension;
  return lower_case(std::move(extension));
}

namespace {

using Path = std::filesystem::path;

constexpr const char* kFolder = "/";  // In the place of an extension.

struct MeshFormat {
  std::string_view extension;  // In small letters.
  std::string_view name;       // For help and messages; empty where it goes without saying.
  unsigned uses;               // Bits of MeshUse.
  MixedMesh (*read)(const Path& path);
  void (*write)(const Path& path, const MeshView& mesh, const MeshWriteOptions& options);
  std::string_view parts = {};  // What is named in it, such as solids, by any text; patches have words.
};

template <class... Uses>
constexpr unsigned bits(Uses... uses) {
  return (0U | ... | (1U << static_cast<unsigned>(uses)));
}

template <auto kWriter>
void write_plainly(const Path& path, const MeshView& mesh, const MeshWriteOptions& /*options*/) {
  kWriter(path, mesh);
}

void write_gmsh(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  io::write_gmsh(path, mesh, options.msh_version);
}

using enum MeshUse;
constexpr unsigned kVolumeIn = bits(kRead, kReadVolume), kTetrahedraOut = bits(kWrite, kWriteVolume),
                   kMixedOut = kTetrahedraOut | bits(kWriteMixed),
                   kSurface = bits(kRead, kWrite, kWriteSurface);

/// Every format, and all that is said of formats anywhere, in the order of the lists.
constexpr auto kFormats = std::to_array<MeshFormat>({
    {".vtu", ".vtu", kVolumeIn | kMixedOut | bits(kCarryMetric), io::read_vtu, io::write_vtu},
    {".vtk", ".vtk", kVolumeIn | kMixedOut | bits(kCarryMetric), io::read_legacy_vtk, io::write_legacy_vtk},
    {".vtk.gz", "", kVolumeIn, io::read_legacy_vtk, nullptr},
    {".mesh", ".mesh", kVolumeIn | kMixedOut, io::read_medit_ascii, write_plainly<io::write_medit_ascii>},
    {".meshb", ".meshb", kVolumeIn | kMixedOut, io::read_medit_binary, write_plainly<io::write_medit_binary>},
    {".msh", ".msh", kVolumeIn | kMixedOut, io::read_gmsh, write_gmsh},
    {".foam", ".foam for OpenFOAM", kMixedOut, nullptr, write_plainly<io::write_foam>},
    {".xdmf", ".xdmf for FEniCS", kTetrahedraOut, nullptr, write_plainly<io::write_xdmf>},
    {kFolder, "a folder NAME-mesh-complete for SimVascular", kTetrahedraOut, nullptr,
     write_plainly<io::write_simvascular>},
    {".vtp", ".vtp", kSurface, io::read_vtp_surface, io::write_vtp_surface},
    {".stl", ".stl", kSurface, io::read_stl, write_plainly<io::write_stl>, "solid"},
    {".stl.gz", "", bits(kRead), io::read_stl, nullptr, "solid"},
    {".obj", ".obj", bits(kRead), io::read_obj, nullptr, "group"},
    {".off", ".off", kSurface, io::read_off, write_plainly<io::write_off>},
    {".sol", ".sol", bits(kMetricAlone), nullptr, nullptr},
    {".solb", ".solb", bits(kMetricAlone), nullptr, nullptr},
});

/// @return nullptr if there is none that can be used so.
const MeshFormat* format_of(const Path& path, MeshUse use) {
  const std::string extension = is_mesh_folder(path) ? kFolder : io::lower_extension(path);
  const auto format = std::ranges::find_if(
      kFormats, [&](const MeshFormat& f) { return f.extension == extension && (f.uses & bits(use)) != 0; });
  return format == kFormats.end() ? nullptr : &*format;
}

/// @throws Error{kBadInput}, as above.
const MeshFormat& known_format_of(const Path& path, MeshUse use) {
  const MeshFormat* const format = format_of(path, use);
  if (format == nullptr) io::fail(path, "unknown mesh format; use " + formats_for(use, " or "));
  return *format;
}

}  // namespace

bool is_for(const Path& path, MeshUse use) {
  return format_of(path, use) != nullptr;
}

std::string formats_for(MeshUse use, std::string_view before_last) {
  std::vector<std::string_view> names;
  for (const MeshFormat& format : kFormats)
    if ((format.uses & bits(use)) != 0 && !format.name.empty()) names.push_back(format.name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{}{}{}", fmt::join(names, ", "), names.empty() ? "" : before_last, last);
}

void write_mesh(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  known_format_of(path, kWrite).write(path, mesh, options);
}

void write_surface(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  known_format_of(path, kWriteSurface).write(path, mesh, options);
}

MixedMesh read_mesh(const Path& path) {
  return read_surface_file(path, "", Context());
}

MixedMesh read_surface_file(const Path& path, const std::string& patch_array, const Context& context) {
  io::check_file(path);
  const MeshFormat& format = known_format_of(path, kRead);
  const bool has_arrays = format.read == io::read_vtp_surface;
  if (!patch_array.empty() && !has_arrays)
    io::fail(path, "has no arrays of cells; `patch_array` is for .vtp");
  MixedMesh mesh = has_arrays ? io::read_vtp_surface_by(path, patch_array, context) : format.read(path);
  for (Patch& patch : mesh.info.patches) patch.name = io::as_utf8(std::move(patch.name));
  for (auto& [label, name] : mesh.info.label_names) name = io::as_utf8(std::move(name));
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
