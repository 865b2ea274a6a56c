// SimVascular's mesh-complete folder: VTK files in which points, cells, regions and faces have numbers.
// svMultiPhysics casts these arrays to 32-bit integers, counts from 1, and takes the name of a file in
// mesh-surfaces/ for that of a boundary condition's face.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "cell_blocks.hpp"
#include "face_ids.hpp"
#include "face_owners.hpp"
#include "file_fault.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/mesh/patch_words.hpp"
#include "mesh_formats.hpp"
#include "output_folder.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSurfaces = "mesh-surfaces";
constexpr const char* kInterfaces = "mesh-interfaces";

/// 1, 2, 3, …
std::vector<std::int32_t> numbers_from_1(std::size_t count) {
  std::vector<std::int32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 1);
  return numbers;
}

/// Where the cells of one shape end in the list of their corners.
std::vector<std::int64_t> cell_ends(std::size_t cells, std::size_t corners) {
  std::vector<std::int64_t> ends(cells);
  for (std::size_t i = 0; i < cells; ++i) ends[i] = static_cast<std::int64_t>((i + 1) * corners);
  return ends;
}

void write_volume(const fs::path& path, const MeshView& mesh) {
  const std::size_t cells = mesh.tetrahedra.size();
  VtkXmlWriter writer(path, "UnstructuredGrid");
  writer.print("<FieldData>\n");
  writer.info_arrays(*mesh.info);
  writer.begin_cells(mesh.points.size(), cells);
  writer.print("<PointData>\n");
  writer.numbers("GlobalNodeID", numbers_from_1(mesh.points.size()));
  writer.print("</PointData>\n<CellData>\n");
  writer.numbers("GlobalElementID", numbers_from_1(cells));
  writer.numbers("ModelRegionID", mesh.tetrahedron_labels);
  writer.print("</CellData>\n");
  writer.points(mesh.points);
  writer.print("<Cells>\n");
  writer.numbers("connectivity", volume_blocks(mesh)[0].vertices);
  writer.numbers("offsets", cell_ends(cells, 4));
  writer.numbers("types", std::vector(cells, static_cast<std::uint8_t>(CellShape::kTetrahedron)));
  writer.print("</Cells>\n</Piece>\n");
  writer.commit();
}

/// Triangles of the mesh in one file, with the points they use in the order of the mesh.
struct FaceFile {
  std::vector<Vec3> points;
  std::vector<std::int32_t> node_ids;
  std::vector<std::int32_t> corners;
  std::vector<std::int32_t> element_ids;
  std::vector<std::int32_t> region_ids;
  std::vector<std::int32_t> face_ids;
};

FaceFile gather_faces(const MeshView& mesh, const std::vector<FaceOwner>& owners,
                      const std::vector<std::uint32_t>& triangles) {
  FaceFile file;
  const std::vector<std::int32_t> id_of = model_face_ids(*mesh.info);
  std::vector<std::uint32_t> used;
  for (const std::uint32_t t : triangles)
    used.insert(used.end(), owners[t].outward.begin(), owners[t].outward.end());
  sort_unique(used);
  for (const std::uint32_t v : used) {
    file.points.push_back(mesh.points[v]);
    file.node_ids.push_back(static_cast<std::int32_t>(v) + 1);
  }
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t v : owners[t].outward)
      file.corners.push_back(static_cast<std::int32_t>(rank_in(used, v)));
    file.element_ids.push_back(static_cast<std::int32_t>(owners[t].cell) + 1);
    file.region_ids.push_back(mesh.tetrahedron_labels[owners[t].cell]);
    file.face_ids.push_back(id_of.at(static_cast<std::size_t>(mesh.triangle_patches[t])));
  }
  return file;
}

void write_faces(const fs::path& path, const FaceFile& file) {
  VtkXmlWriter writer(path, "PolyData");
  writer.begin_poly_data(file.points.size(), 0, file.face_ids.size());
  writer.print("<PointData>\n");
  writer.numbers("GlobalNodeID", file.node_ids);
  writer.print("</PointData>\n<CellData>\n");
  writer.numbers("GlobalElementID", file.element_ids);
  writer.numbers("ModelRegionID", file.region_ids);
  writer.numbers("ModelFaceID", file.face_ids);
  writer.print("</CellData>\n");
  writer.points(file.points);
  writer.cells("Polys", file.corners, cell_ends(file.face_ids.size(), 3));
  writer.print("</Piece>\n");
  writer.commit();
}

/// File names for the patches: without what a shell, a folder or an input file of the solver would trip over,
/// and no two alike.
std::vector<std::string> file_names(const std::vector<Patch>& patches) {
  std::vector<std::string> names;
  PatchWords words;
  for (std::size_t p = 0; p < patches.size(); ++p)
    names.push_back(words.add(patches[p].name, fmt::format("patch_{}", p + 1)) + ".vtp");
  return names;
}

/// The triangles of each file, by what bounds the mesh and what lies in it.
struct FaceGroups {
  std::vector<std::uint32_t> exterior;
  std::vector<std::uint32_t> walls;
  std::vector<std::vector<std::uint32_t>> surfaces;    ///< By patch.
  std::vector<std::vector<std::uint32_t>> interfaces;  ///< By patch.
};

FaceGroups group_faces(const fs::path& path, const MeshView& mesh, const std::vector<FaceOwner>& owners) {
  const std::vector<Patch>& patches = mesh.info->patches;
  FaceGroups groups{{}, {}, decltype(FaceGroups::surfaces)(patches.size()), {}};
  groups.interfaces.resize(patches.size());
  for (std::uint32_t t = 0; t < owners.size(); ++t) {
    if (owners[t].cell == FaceOwner::kNone)
      fail(path, fmt::format("boundary triangle {} belongs to no tetrahedron; remove the triangles, which "
                             "are then found anew",
                             t));
    const auto patch = static_cast<std::size_t>(mesh.triangle_patches[t]);
    if (patch >= patches.size())
      fail(path, fmt::format("boundary triangle {} has the unknown patch {}; renumber them", t,
                             mesh.triangle_patches[t]));
    if (owners[t].between) {
      groups.interfaces[patch].push_back(t);
      continue;
    }
    groups.exterior.push_back(t);
    groups.surfaces[patch].push_back(t);
    if (patches[patch].kind == PatchKind::kWall) groups.walls.push_back(t);
  }
  if (groups.exterior.empty()) fail(path, kNoFaces);
  return groups;
}

void make_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) fail(folder, fmt::format("cannot be made ({})", failed.message()));
}

bool holds_only_vtp(const fs::path& folder) {
  std::error_code ignored;
  return std::all_of(
      fs::directory_iterator(folder, ignored), fs::directory_iterator(),
      [](const auto& entry) { return entry.is_regular_file() && entry.path().extension() == ".vtp"; });
}

fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

bool is_simvascular_folder(const fs::path& path) {
  return without_slash(path).filename().string().ends_with("mesh-complete");
}

/// The folder is replaced as a whole, so that no face of an older mesh stays in it: it may hold nothing else.
void check_simvascular_folder(const fs::path& named) {
  const fs::path path = without_slash(named);
  static constexpr std::array<std::string_view, 3> kFiles = {
      "mesh-complete.mesh.vtu", "mesh-complete.exterior.vtp", "walls_combined.vtp"};
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return;
  if (!fs::is_directory(path, ignored))
    fail(path, "is a file, and a folder is to be written; remove it or choose another name");
  for (const fs::directory_entry& entry : fs::directory_iterator(path, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool ours = entry.is_directory()
                          ? (name == kSurfaces || name == kInterfaces) && holds_only_vtp(entry.path())
                          : std::ranges::find(kFiles, name) != kFiles.end();
    if (!ours)
      fail(path,
           fmt::format("would be replaced, and {} in it is no part of a mesh; choose another name", name));
  }
}

void write_simvascular(const fs::path& named, const MeshView& mesh) {
  const fs::path path = without_slash(named);
  check_simvascular_folder(path);
  const std::vector<FaceOwner> owners = find_face_owners(mesh);
  const FaceGroups groups = group_faces(path, mesh, owners);
  const std::vector<std::string> names = file_names(mesh.info->patches);
  OutputFolder folder(path);
  const auto write_group = [&](const fs::path& name, const std::vector<std::uint32_t>& triangles) {
    if (triangles.empty()) return;
    make_folder((folder.path() / name).parent_path());
    write_faces(folder.path() / name, gather_faces(mesh, owners, triangles));
  };
  write_volume(folder.path() / "mesh-complete.mesh.vtu", mesh);
  write_group("mesh-complete.exterior.vtp", groups.exterior);
  write_group("walls_combined.vtp", groups.walls);
  for (std::size_t p = 0; p < names.size(); ++p) {
    write_group(fs::path(kSurfaces) / names[p], groups.surfaces[p]);
    write_group(fs::path(kInterfaces) / names[p], groups.interfaces[p]);
  }
  folder.commit();
}

}  // namespace lumesh::io
