#include "lumesh/io/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "file_fault.hpp"
#include "mesh_formats.hpp"
#include "utf8.hpp"

namespace lumesh {

std::string io::lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  if (extension == ".gz") extension = path.stem().extension().string() + extension;
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

namespace {

using io::lower_extension;

[[noreturn]] void refuse(const std::filesystem::path& path, const char* known) {
  io::fail(path, fmt::format("unknown mesh format; use {}", known));
}

}  // namespace

void write_mesh(const std::filesystem::path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  if (is_mesh_folder(path)) return io::write_simvascular(path, mesh);
  const std::string extension = lower_extension(path);
  if (extension == ".vtu") return io::write_vtu(path, mesh, options);
  if (extension == ".vtk") return io::write_legacy_vtk(path, mesh, options);
  if (extension == ".mesh") return io::write_medit_ascii(path, mesh);
  if (extension == ".meshb") return io::write_medit_binary(path, mesh);
  if (extension == ".msh") return io::write_gmsh(path, mesh, options.msh_version);
  if (extension == ".foam") return io::write_foam(path, mesh);
  if (extension == ".xdmf") return io::write_xdmf(path, mesh);
  if (is_surface_file(path)) return write_surface(path, mesh, options);
  refuse(
      path,
      ".vtu, .vtk, .mesh, .meshb, .msh, .foam, .xdmf, a folder NAME-mesh-complete, or .vtp and .stl for the "
      "boundary");
}

void write_surface(const std::filesystem::path& path, const MeshView& mesh, const MeshWriteOptions& options) {
  const std::string extension = lower_extension(path);
  if (extension == ".vtp") return io::write_vtp_surface(path, mesh, options);
  if (extension == ".stl") return io::write_stl(path, mesh);
  refuse(path, ".vtp or .stl for a boundary");
}

namespace {

MixedMesh read_by_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".vtu") return io::read_vtu(path);
  if (extension == ".vtk" || extension == ".vtk.gz") return io::read_legacy_vtk(path);
  if (extension == ".mesh") return io::read_medit_ascii(path);
  if (extension == ".meshb") return io::read_medit_binary(path);
  if (extension == ".msh") return io::read_gmsh(path);
  if (extension == ".stl") return io::read_stl(path);
  if (extension == ".vtp") return io::read_vtp_surface(path);
  refuse(path, ".vtu, .vtk, .mesh, .meshb, .msh, .stl or .vtp");
}

}  // namespace

MixedMesh read_mesh(const std::filesystem::path& path) {
  io::check_file(path);
  MixedMesh mesh = read_by_extension(path);
  for (Patch& patch : mesh.info.patches) patch.name = io::as_utf8(std::move(patch.name));
  for (auto& [label, name] : mesh.info.label_names) name = io::as_utf8(std::move(name));
  return mesh;
}

bool is_mesh_file(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 8> kKnown = {".vtu",   ".vtk", ".vtk.gz", ".mesh",
                                                      ".meshb", ".msh", ".stl",    ".vtp"};
  return std::find(kKnown.begin(), kKnown.end(), lower_extension(path)) != kKnown.end();
}

bool is_volume_file(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 7> kKnown = {".vtu", ".vtk",  ".mesh", ".meshb",
                                                      ".msh", ".foam", ".xdmf"};
  return is_mesh_folder(path) ||
         std::find(kKnown.begin(), kKnown.end(), lower_extension(path)) != kKnown.end();
}

bool is_mixed_volume_file(const std::filesystem::path& path) {
  return is_volume_file(path) && !is_mesh_folder(path) && lower_extension(path) != ".xdmf";
}

bool is_mesh_folder(const std::filesystem::path& path) {
  return io::is_simvascular_folder(path);
}

void check_mesh_folder(const std::filesystem::path& path) {
  if (is_mesh_folder(path)) io::check_simvascular_folder(path);
  if (lower_extension(path) == ".foam") io::check_foam_case(path);
}

bool is_surface_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".vtp" || extension == ".stl";
}

}  // namespace lumesh
