#include "lumesh/io/file_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/io/patch_names.hpp"
#include "mesh_formats.hpp"

namespace lumesh {

std::string io::lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  if (lower_case(extension) == ".gz") extension = path.stem().extension().string() + extension;
  return lower_case(std::move(extension));
}

namespace {

using enum FileUse;
using io::bits, io::FileFormat;
using Path = std::filesystem::path;

// In the place of an extension.
constexpr const char *kMeshFolder = "/", *kDicom = "DICOM";

template <auto kWriter>
void write_plainly(const Path& path, const MeshView& mesh, const MeshWriteOptions& /*options*/) {
  kWriter(path, mesh);
}

void write_gmsh(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  io::write_gmsh(path, mesh, options.msh_version);
}

MixedMesh points_of_vtp(const Path& path) {
  return io::read_vtk_xml_points(path, "PolyData");
}
MixedMesh points_of_vtu(const Path& path) {
  return io::read_vtk_xml_points(path, "UnstructuredGrid");
}
PointData data_of_vtp(const Path& path) {
  return io::read_vtk_xml_point_data(path, "PolyData");
}
PointData data_of_vtu(const Path& path) {
  return io::read_vtk_xml_point_data(path, "UnstructuredGrid");
}

/// Beside the bits of uses: what is written has no place for names of patches.
constexpr unsigned kNameless = 1U << 31U;

constexpr unsigned kVolumeIn = bits(kRead, kReadVolume, kPoints), kTetrahedraOut = bits(kWrite, kWriteVolume),
                   kVolume = kVolumeIn | kTetrahedraOut | bits(kWriteMixed),
                   kVtkVolume = kVolume | bits(kCarryMetric, kLabelAlias, kPointData),
                   kSurfaceIn = bits(kRead, kPoints), kSurface = kSurfaceIn | bits(kWrite, kWriteSurface),
                   kTable = bits(kPoints, kPointData), kImage = bits(kReadImage, kWriteImage);

constexpr FileFormat::Code kLegacyVtk = {io::read_legacy_vtk, io::write_legacy_vtk, io::read_legacy_vtk_by,
                                         io::read_legacy_vtk_points, io::read_legacy_vtk_point_data};
constexpr FileFormat::Code kText = {.read_points = io::read_text_points,
                                    .read_point_data = io::read_text_point_data};

/// Every format, and all that is said of formats anywhere, in the order of the lists.
constexpr auto kFormats = std::to_array<FileFormat>({
    {".vtu", ".vtu", kVtkVolume, {io::read_vtu, io::write_vtu, nullptr, points_of_vtu, data_of_vtu}},
    {".vtk", ".vtk", kVtkVolume | bits(kPatchArray), kLegacyVtk},
    {".vtk.gz", "", kVolumeIn | bits(kPointData, kPatchArray), kLegacyVtk},
    {".mesh", ".mesh", kVolume, {io::read_medit_ascii, write_plainly<io::write_medit_ascii>}},
    {".meshb", ".meshb", kVolume | kNameless, {io::read_medit_binary, write_plainly<io::write_medit_binary>}},
    {".msh", ".msh", kVolume, {io::read_gmsh, write_gmsh}},
    {".foam",
     ".foam for OpenFOAM",
     kTetrahedraOut | bits(kWriteMixed, kWordNames),
     {.write = write_plainly<io::write_foam>}},
    {".xdmf", ".xdmf for FEniCS", kTetrahedraOut, {.write = write_plainly<io::write_xdmf>}},
    {kMeshFolder,
     "a folder NAME-mesh-complete for SimVascular",
     kTetrahedraOut | bits(kWordNames),
     {.write = write_plainly<io::write_simvascular>}},
    {".vtp",
     ".vtp",
     kSurface | bits(kPatchArray, kLabelAlias, kPointData, kLines),
     {io::read_vtp_surface, io::write_vtp_surface, io::read_vtp_surface_by, points_of_vtp, data_of_vtp}},
    {".stl",
     ".stl",
     kSurface | kNameless | bits(kWriteSingle),
     {io::read_stl, write_plainly<io::write_stl>},
     "solid"},
    {".stl.gz", "", kSurfaceIn, {io::read_stl}, "solid"},
    {".obj", ".obj", kSurfaceIn, {io::read_obj}, "group"},
    {".ply", ".ply", kSurfaceIn, {io::read_ply}},
    {".off", ".off", kSurface | kNameless, {io::read_off, write_plainly<io::write_off>}},
    {".sol", ".sol", bits(kMetricAlone)},
    {".solb", ".solb", bits(kMetricAlone)},
    {".csv", ".csv", kTable, kText},
    {".txt", ".txt", kTable, kText},
    {".dat", ".dat", kTable, kText},
    {".xyz", ".xyz", bits(kPoints), kText},
    {".pts", ".pts", bits(kPoints), kText},
    {".nrrd", ".nrrd", kImage, {.write_image = io::write_nrrd}},
    {".nhdr", ".nhdr", bits(kReadImage)},
    {".nii", ".nii", kImage, {.write_image = io::write_nifti}},
    {".nii.gz", ".nii.gz", kImage, {.write_image = io::write_nifti}},
    {".mha", ".mha", bits(kReadImage)},
    {".mhd", ".mhd", bits(kReadImage)},
    {".gipl", ".gipl", bits(kReadImage)},
    {".gipl.gz", ".gipl.gz", bits(kReadImage)},
    {kDicom, "DICOM folder", bits(kReadImage)},
});

struct UseWords {
  FileUse use;
  std::string_view words, unknown;
};
constexpr auto kUses = std::to_array<UseWords>({
    {kRead, "read", "mesh format"},
    {kReadVolume, "read volume", "mesh format"},
    {kWrite, "write", "mesh format"},
    {kWriteVolume, "write volume", "mesh format"},
    {kWriteMixed, "write mixed", "mesh format"},
    {kWriteSurface, "write surface", "surface format"},
    {kWordNames, "word names", "mesh format"},
    {kWriteSingle, "write single", "surface format"},
    {kLabelAlias, "label alias", "mesh format"},
    {kPatchArray, "patch array", "surface format"},
    {kCarryMetric, "carry metric", "metric format"},
    {kMetricAlone, "metric alone", "metric format"},
    {kPoints, "points", "format of points"},
    {kPointData, "point data", "format of data on points"},
    {kLines, "lines", "format of lines"},
    {kReadImage, "read image", "image format"},
    {kWriteImage, "write image", "image format"},
});

/// @return nullptr if there is none that can be used so.
const FileFormat* found_format(const Path& path, FileUse use) {
  const std::string extension = is_mesh_folder(path) ? kMeshFolder : io::lower_extension(path);
  const auto format = std::ranges::find_if(
      kFormats, [&](const FileFormat& f) { return f.extension == extension && f.serves(use); });
  return format == kFormats.end() ? nullptr : &*format;
}

}  // namespace

const FileFormat& io::format_of(const Path& path, FileUse use) {
  require_format(path, use);
  return *found_format(path, use);
}

bool is_for(const Path& path, FileUse use) {
  return found_format(path, use) != nullptr;
}

bool is_mesh_file(const Path& path) {
  return is_for(path, kRead);
}

bool io::is_written_only(const Path& path) {
  return is_for(path, kWrite) && !is_for(path, kRead);
}

bool is_boundary_alone(const Path& path) {
  return is_for(path, kWriteSurface) && !keeps_patch_names(path);
}

bool keeps_patch_names(const Path& path) {
  const FileFormat* const format = found_format(path, kWrite);
  return format != nullptr && (format->uses & kNameless) == 0;
}

void require_format(const Path& path, FileUse use, ErrorKind kind) {
  if (is_for(path, use)) return;
  if ((use == kRead || use == kReadVolume) && io::is_written_only(path))
    io::fail(path, io::kWrittenOnly, kind);
  const auto words = std::ranges::find(kUses, use, &UseWords::use);
  io::fail(path, fmt::format("unknown {}; use {}", words->unknown, formats_for(use, " or ")), kind);
}

std::string formats_for(FileUse use, std::string_view before_last) {
  std::vector<std::string_view> names;
  for (const FileFormat& format : kFormats)
    if (format.serves(use) && !format.name.empty()) names.push_back(format.name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{}{}{}", fmt::join(names, ", "), names.empty() ? "" : before_last, last);
}

std::vector<std::string_view> format_names(FileUse use) {
  std::vector<std::string_view> names;
  for (const FileFormat& format : kFormats)
    if (format.serves(use)) names.push_back(format.name.empty() ? format.extension : format.name);
  return names;
}

std::vector<std::pair<FileUse, std::string_view>> file_uses() {
  std::vector<std::pair<FileUse, std::string_view>> uses;
  for (const UseWords& one : kUses) uses.emplace_back(one.use, one.words);
  return uses;
}

std::string meaning_of(const Option& option) {
  return option.meaning + (option.file_use ? " (" + formats_for(*option.file_use) + ")" : "");
}

}  // namespace lumesh
