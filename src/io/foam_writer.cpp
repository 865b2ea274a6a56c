// OpenFOAM's polyMesh, text: https://doc.cfd.direct/openfoam/user-guide-v12/mesh-files; the order of faces:
// http://openfoamwiki.net/index.php/Write_OpenFOAM_meshes
#include <fmt/format.h>

#include <deque>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/io/new_folder.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/mesh/patch_words.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/parallel/loops.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "output_file.hpp"
#include "poly_mesh.hpp"

namespace lumesh::io {

namespace fs = std::filesystem;

namespace {

using Text = fmt::memory_buffer;

void append_number(Text& text, std::size_t number) {
  const fmt::format_int digits(number);
  text.append(digits.data(), digits.data() + digits.size());
}

void append_line(Text& text, std::size_t number) {
  append_number(text, number);
  text.push_back('\n');
}

/// A list of `count` items, one per line; append(text, i) gives line i. Lines are made in parallel, a batch
/// at a time.
template <class Append>
void write_list(OutputFile& file, std::size_t count, const Append& append) {
  constexpr std::size_t kBlock = 1 << 13;
  constexpr std::size_t kBatch = 64 * kBlock;
  std::vector<Text> texts(std::min((count + kBlock - 1) / kBlock, kBatch / kBlock));
  file.print("{}\n(\n", count);
  for (std::size_t start = 0; start < count; start += kBatch) {
    const std::size_t lines = std::min(kBatch, count - start);
    parallel::for_each_block(lines, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
      texts[b].clear();
      for (std::size_t i = begin; i < end; ++i) append(texts[b], start + i);
    });
    for (std::size_t b = 0; b * kBlock < lines; ++b) file.write(texts[b].data(), texts[b].size());
  }
  file.write(")\n");
}

void write_header(OutputFile& file, std::string_view content, std::string_view object,
                  const std::string& note = {}, std::string_view location = "constant/polyMesh") {
  file.print("FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {};\n", content);
  if (!note.empty()) file.print("    note        \"{}\";\n", note);
  file.print("    location    \"{}\";\n    object      {};\n}}\n\n", location, object);
}

/// The files of a case, which appear together when all are complete.
class CaseFiles {
 public:
  explicit CaseFiles(const fs::path& foam_file)
      : foam_file_(foam_file),
        constant_(foam_file.parent_path() / "constant"),
        poly_mesh_(constant_.path() / "polyMesh") {
    const fs::path system = foam_file.parent_path() / "system";
    if (!fs::exists(fs::symlink_status(system))) system_.emplace(system);
  }
  OutputFile& add(const char* name) { return files_.emplace_back(poly_mesh_.path() / name); }
  /// Whether the user has no settings there yet, which would be theirs to change.
  [[nodiscard]] bool wants_settings() const { return system_.has_value(); }
  OutputFile& add_setting(const char* name) { return files_.emplace_back(system_->path() / name); }
  void commit() {
    // A full disk must be found before the first file is replaced.
    for (OutputFile& file : files_) file.flush();
    for (OutputFile& file : files_) file.commit();
    foam_file_.commit();
  }

 private:
  OutputFile foam_file_;  ///< Empty: ParaView and others find the case by its name.
  NewFolder constant_;
  NewFolder poly_mesh_;
  std::optional<NewFolder> system_;
  std::deque<OutputFile> files_;
};

/// Without these no program of OpenFOAM looks at a mesh. What solvers need besides is the user's to say.
void write_settings(CaseFiles& files) {
  constexpr std::pair<const char*, const char*> kSettings[] = {
      {"controlDict",
       "startFrom       startTime;\nstartTime       0;\nstopAt          endTime;\nendTime         1;\n"
       "deltaT          1;\nwriteControl    timeStep;\nwriteInterval   1;\n"},
      {"fvSchemes",
       "ddtSchemes {}\ngradSchemes {}\ndivSchemes {}\nlaplacianSchemes {}\ninterpolationSchemes {}\n"
       "snGradSchemes {}\n"},
      {"fvSolution", "solvers {}\n"}};
  for (const auto& [name, content] : kSettings) {
    OutputFile& file = files.add_setting(name);
    write_header(file, "dictionary", name, {}, "system");
    file.write(content);
  }
}

/// How many of the mesh's units are a metre.
double units_per_metre(const fs::path& path, const std::string& unit) {
  if (const double mm = unit_in_mm(unit); mm > 0) return 1000 / mm;
  fail(path,
       fmt::format("OpenFOAM wants metres, and the mesh is in \"{}\"; say its unit: mm, cm, m, um or in",
                   unit));
}

class FoamWriter {
 public:
  FoamWriter(const fs::path& path, const MeshView& mesh)
      : mesh_(mesh),
        units_per_metre_(units_per_metre(path, mesh.info->unit)),
        poly_(build_poly_mesh(path, mesh)),
        points_(points_in_use(mesh)),
        files_(path) {}

  void write() {
    write_points(files_.add("points"));
    write_faces(files_.add("faces"));
    write_owners(files_.add("owner"));
    write_neighbours(files_.add("neighbour"));
    write_boundary(files_.add("boundary"));
    write_cell_zones(files_.add("cellZones"));
    write_face_zones(files_.add("faceZones"));
    write_point_zones(files_.add("pointZones"));
    if (files_.wants_settings()) write_settings(files_);
    files_.commit();
  }

 private:
  void write_points(OutputFile& file) {
    write_header(file, "vectorField", "points");
    write_list(file, points_.points().size(), [&](Text& text, std::size_t i) {
      const Vec3& p = mesh_.points[points_.points()[i]];  // Divided: the nearest number to the true quotient.
      fmt::format_to(std::back_inserter(text), "({} {} {})\n", p.x() / units_per_metre_,
                     p.y() / units_per_metre_, p.z() / units_per_metre_);
    });
  }

  void write_faces(OutputFile& file) {
    write_header(file, "faceList", "faces");
    write_list(file, poly_.faces.size(), [&](Text& text, std::size_t f) {
      const Cell<4> corners = poly_.sides.corners(poly_.faces[f]);
      const std::size_t count = corners[2] == corners[3] ? 3 : 4;
      append_number(text, count);
      for (std::size_t i = 0; i < count; ++i) {
        text.push_back(i == 0 ? '(' : ' ');
        append_number(text, points_.at(corners[i]));
      }
      text.push_back(')');
      text.push_back('\n');
    });
  }

  [[nodiscard]] std::string counts() const {
    return fmt::format("nPoints:{} nCells:{} nFaces:{} nInternalFaces:{}", points_.points().size(),
                       poly_.sides.cell_count(), poly_.faces.size(), poly_.neighbours.size());
  }

  void write_owners(OutputFile& file) {
    write_header(file, "labelList", "owner", counts());
    write_list(file, poly_.faces.size(),
               [&](Text& text, std::size_t f) { append_line(text, poly_.sides.cell_of(poly_.faces[f])); });
  }

  void write_neighbours(OutputFile& file) {
    write_header(file, "labelList", "neighbour", counts());
    write_list(file, poly_.neighbours.size(),
               [&](Text& text, std::size_t f) { append_line(text, poly_.neighbours[f]); });
  }

  [[nodiscard]] std::string add_patch(std::int32_t patch, PatchWords& words) const {
    if (patch == kNoPatch) return words.add("unnamed", "");
    const auto index = static_cast<std::size_t>(patch);
    const auto& patches = mesh_.info->patches;
    return words.add(index < patches.size() ? patches[index].name : "", fmt::format("patch_{}", patch + 1));
  }

  [[nodiscard]] std::string_view type_of(std::int32_t patch) const {
    const auto index = static_cast<std::size_t>(patch);
    if (index >= mesh_.info->patches.size()) return "patch";
    const PatchKind kind = mesh_.info->patches[index].kind;
    if (kind == PatchKind::kSymmetry) return "symmetry";
    return kind == PatchKind::kWall ? "wall" : "patch";
  }

  void write_boundary(OutputFile& file) {
    write_header(file, "polyBoundaryMesh", "boundary");
    MeshInfo info = *mesh_.info;
    info.unit = "m";
    file.print("// {}\n\n{}\n(\n", info_to_json(info), poly_.patches.size());
    PatchWords words;
    std::vector<std::string> names;
    for (const PolyPatch& patch : poly_.patches) names.push_back(add_patch(patch.patch, words));
    // All walls at once are the group "wall", unless that would also be the name of one patch.
    const bool has_group = !words.contains("wall");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const PolyPatch& patch = poly_.patches[i];
      const std::string_view type = type_of(patch.patch);
      file.print("    {}\n    {{\n        type            {};\n", names[i], type);
      if (type == "wall" && has_group) file.print("        inGroups        1(wall);\n");
      file.print("        nFaces          {};\n        startFace       {};\n    }}\n", patch.count,
                 patch.first);
    }
    file.print(")\n");
  }

  void write_cell_zones(OutputFile& file) {
    std::map<Label, std::vector<std::size_t>> zones;
    std::size_t cell = 0;
    for (const CellBlock& block : volume_blocks(mesh_))
      for (const Label label : block.tags) zones[label].push_back(cell++);
    write_header(file, "regIOobject", "cellZones");
    file.print("{}\n(\n", zones.size());
    PatchWords words;
    std::map<Label, std::string> names = label_words(mesh_.info->label_names);
    for (const auto& zone : zones) {
      file.print("{}\n{{\n    type cellZone;\n    cellLabels List<label>\n",
                 words.add(names[zone.first], fmt::format("label_{}", zone.first)));
      const std::vector<std::size_t>& cells = zone.second;
      write_list(file, cells.size(), [&](Text& text, std::size_t i) { append_line(text, cells[i]); });
      file.print(";\n}}\n");
    }
    file.print(")\n");
  }

  void write_face_zones(OutputFile& file) {
    write_header(file, "regIOobject", "faceZones");
    file.print("{}\n(\n", poly_.zones.size());
    PatchWords words;
    for (const PolyZone& zone : poly_.zones) {
      file.print("{}\n{{\n    type faceZone;\n    faceLabels List<label>\n", add_patch(zone.patch, words));
      write_list(file, zone.faces.size(),
                 [&](Text& text, std::size_t i) { append_line(text, zone.faces[i]); });
      file.print(";\n    flipMap List<bool>\n");
      write_list(file, zone.faces.size(),
                 [&](Text& text, std::size_t i) { append_line(text, zone.reversed[i]); });
      file.print(";\n}}\n");
    }
    file.print(")\n");
  }

  /// None, but those of an earlier mesh must not stay.
  static void write_point_zones(OutputFile& file) {
    write_header(file, "regIOobject", "pointZones");
    file.print("0\n(\n)\n");
  }

  const MeshView& mesh_;
  double units_per_metre_;
  PolyMesh poly_;
  PointNumbers points_;  // Points that cells use; OpenFOAM takes others for a fault.
  CaseFiles files_;
};

}  // namespace

void check_foam_case(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  if (fs::exists(path, ignored) || !fs::exists(folder / "constant/polyMesh/faces", ignored)) return;
  std::set<std::string> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (lower_extension(entry.path()) == ".foam") others.insert(entry.path().filename().string());
  if (others.empty()) return;  // A mesh of OpenFOAM's own tools, which replace each other's, too.
  fail(path, fmt::format(
                 "would replace the mesh of {0}, since a folder has one constant/polyMesh; write {0} again, "
                 "or into another folder",
                 *others.begin()));
}

void write_foam(const fs::path& path, const MeshView& mesh) {
  check_foam_case(path);
  FoamWriter(path, mesh).write();
}

}  // namespace lumesh::io
