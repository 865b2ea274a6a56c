// Gmsh MSH, ASCII, https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format: 4.1 and 2.2.
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "output_file.hpp"

namespace lumesh::io {

namespace {

using Boxes = std::map<std::int32_t, Box3>;

/// The boxes of the cells of each tag; every tag that occurs is in the result.
template <std::size_t N>
Boxes boxes_by_tag(std::span<const Vec3> points, const std::array<CellBlock, N>& blocks) {
  Boxes boxes;
  for (const CellBlock& block : blocks) {
    Box3* box = nullptr;
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (box == nullptr || block.tags[i] != block.tags[i - 1]) box = &boxes[block.tags[i]];
      for (const std::uint32_t v : block.cell(i)) box->extend(points[v]);
    }
  }
  return boxes;
}

std::string without_quotes(std::string name) {
  for (char& c : name)
    if (c == '"' || c == '\n' || c == '\r') c = '\'';
  return name;
}

class GmshWriter {
 public:
  GmshWriter(const std::filesystem::path& path, const MeshView& mesh)
      : file_(path),
        mesh_(mesh),
        volumes_(boxes_by_tag(mesh.points, volume_blocks(mesh))),
        surfaces_(boxes_by_tag(mesh.points, face_blocks(mesh))) {
    if ((!volumes_.empty() && volumes_.begin()->first < 1) ||
        (!surfaces_.empty() && surfaces_.begin()->first < 0))
      fail(path, "Gmsh needs labels from 1 and patches from 0; renumber them or choose .vtu");
    for (std::size_t p = 0; p < mesh.info->patches.size(); ++p)
      surfaces_.try_emplace(static_cast<std::int32_t>(p));
  }

  void write(MshVersion version) {
    file_.print("$MeshFormat\n{} 0 8\n$EndMeshFormat\n", version == MshVersion::k41 ? "4.1" : "2.2");
    write_info();
    write_names();
    if (version == MshVersion::k41) {
      write_entities();
      write_nodes_41();
      write_elements_41();
    } else {
      write_nodes_22();
      write_elements_22();
    }
    file_.commit();
  }

 private:
  /// '$' would look like a section to readers that take lines of limited length.
  void write_info() {
    std::string json = info_to_json(*mesh_.info);
    for (std::size_t at = json.find('$'); at != std::string::npos; at = json.find('$', at))
      json.replace(at, 1, "\\u0024");
    file_.print("$Comments\n{}\n$EndComments\n", json);
  }

  void write_names() {
    file_.print("$PhysicalNames\n{}\n", surfaces_.size() + volumes_.size());
    for (const auto& [patch, box] : surfaces_) {
      const auto index = static_cast<std::size_t>(patch);
      const std::string name =
          index < mesh_.info->patches.size() ? mesh_.info->patches[index].name : std::string();
      file_.print("2 {} \"{}\"\n", patch + 1,
                  name.empty() ? fmt::format("patch_{}", patch) : without_quotes(name));
    }
    for (const auto& [label, box] : volumes_) {
      const auto name = mesh_.info->label_names.find(label);
      file_.print("3 {} \"{}\"\n", label,
                  name == mesh_.info->label_names.end() ? fmt::format("label_{}", label)
                                                        : without_quotes(name->second));
    }
    file_.print("$EndPhysicalNames\n");
  }

  void print_box(std::int32_t tag, const Box3& box) {
    const Vec3 low = box.isEmpty() ? Vec3(Vec3::Zero()) : box.min();
    const Vec3 high = box.isEmpty() ? Vec3(Vec3::Zero()) : box.max();
    file_.print("{} {} {} {} {} {} {} 1 {} ", tag, low.x(), low.y(), low.z(), high.x(), high.y(), high.z(),
                tag);
  }

  /// The cells that may have one of the mesh's faces.
  [[nodiscard]] MixedMesh cells_at_faces() const {
    std::vector<std::uint8_t> is_at_face(mesh_.points.size(), 0);
    for (const CellBlock& block : face_blocks(mesh_))
      for (const std::uint32_t v : block.vertices) is_at_face[v] = 1;
    MixedMesh near;
    near.points.assign(mesh_.points.begin(), mesh_.points.end());
    const auto add = [&](const auto& cells, std::span<const Label> labels, auto& to, auto& to_labels) {
      for (std::size_t c = 0; c < cells.size(); ++c) {
        if (std::ranges::count_if(cells[c], [&](std::uint32_t v) { return is_at_face[v] != 0; }) < 3)
          continue;
        to.push_back(cells[c]);
        to_labels.push_back(labels[c]);
      }
    };
    add(mesh_.tetrahedra, mesh_.tetrahedron_labels, near.tetrahedra, near.tetrahedron_labels);
    add(mesh_.pyramids, mesh_.pyramid_labels, near.pyramids, near.pyramid_labels);
    add(mesh_.prisms, mesh_.prism_labels, near.prisms, near.prism_labels);
    add(mesh_.hexahedra, mesh_.hexahedron_labels, near.hexahedra, near.hexahedron_labels);
    return near;
  }
  /// Patches around each label, negative where their faces point into it. One patch may have faces of several
  /// labels, as an opening of a lumen and its layers.
  [[nodiscard]] std::map<Label, std::set<std::int64_t>> surfaces_by_label() const {
    std::map<Label, std::set<std::int64_t>> result;
    if (volumes_.size() == 1) {
      for (const auto& [patch, box] : surfaces_) result[volumes_.begin()->first].insert(patch + 1);
      return result;
    }
    const MixedMesh near = cells_at_faces();
    const CellSides sides(near.view());
    const auto add = [&](const FaceCorners& face, std::int32_t patch) {
      for (const CellSide& side : sides.find(face))
        result[sides.label(side)].insert(are_opposite(face, sides.outward(side)) ? -(patch + 1) : patch + 1);
    };
    for (std::size_t f = 0; f < mesh_.triangles.size(); ++f)
      add(face_of(mesh_.triangles[f]), mesh_.triangle_patches[f]);
    for (std::size_t f = 0; f < mesh_.quadrilaterals.size(); ++f)
      add(face_of(mesh_.quadrilaterals[f]), mesh_.quadrilateral_patches[f]);
    return result;
  }

  void write_entities() {
    file_.print("$Entities\n0 0 {} {}\n", surfaces_.size(), volumes_.size());
    for (const auto& [patch, box] : surfaces_) {
      print_box(patch + 1, box);
      file_.print("0\n");
    }
    std::map<Label, std::set<std::int64_t>> surfaces = surfaces_by_label();
    for (const auto& [label, box] : volumes_) {
      print_box(label, box);
      const std::set<std::int64_t>& tags = surfaces[label];
      file_.print("{}", tags.size());
      for (const std::int64_t tag : tags) file_.print(" {}", tag);
      file_.print("\n");
    }
    file_.print("$EndEntities\n");
  }

  /// All nodes in one block, on the first volume, or on the first surface where there is no volume.
  void write_nodes_41() {
    const std::size_t count = mesh_.points.size();
    if (count == 0 || (volumes_.empty() && surfaces_.empty())) {
      file_.print("$Nodes\n0 0 0 0\n$EndNodes\n");
      return;
    }
    const int dimension = volumes_.empty() ? 2 : 3;
    const std::int32_t tag = volumes_.empty() ? surfaces_.begin()->first + 1 : volumes_.begin()->first;
    file_.print("$Nodes\n1 {} 1 {}\n{} {} 0 {}\n", count, count, dimension, tag, count);
    for (std::size_t i = 1; i <= count; ++i) file_.print("{}\n", i);
    for (const Vec3& p : mesh_.points) file_.print("{} {} {}\n", p.x(), p.y(), p.z());
    file_.print("$EndNodes\n");
  }

  void write_nodes_22() {
    file_.print("$Nodes\n{}\n", mesh_.points.size());
    std::size_t number = 0;
    for (const Vec3& p : mesh_.points) file_.print("{} {} {} {}\n", ++number, p.x(), p.y(), p.z());
    file_.print("$EndNodes\n");
  }

  void print_corners(const CellBlock& block, std::size_t i) {
    for (std::size_t k = 0; k < block.corners; ++k)
      file_.print(" {}", std::uint64_t{block.corner_of_gmsh(i, k)} + 1);
    file_.print("\n");
  }

  [[nodiscard]] std::size_t element_count() const {
    return mesh_.cell_count() + mesh_.triangles.size() + mesh_.quadrilaterals.size();
  }

  /// The parts of `blocks` with one tag each. A pass per tag: there are few, and it takes no memory.
  template <std::size_t N>
  static std::size_t count_parts(const std::array<CellBlock, N>& blocks) {
    std::size_t parts = 0;
    for (const CellBlock& block : blocks)
      parts += std::set<std::int32_t>(block.tags.begin(), block.tags.end()).size();
    return parts;
  }

  void write_part(const CellBlock& block, int dimension, std::int32_t tag, std::int32_t entity,
                  std::size_t& number) {
    const auto count = std::ranges::count(block.tags, tag);
    if (count == 0) return;
    file_.print("{} {} {} {}\n", dimension, entity, names_of(block.shape).gmsh_type, count);
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (block.tags[i] != tag) continue;
      file_.print("{}", ++number);
      print_corners(block, i);
    }
  }

  void write_elements_41() {
    const auto faces = face_blocks(mesh_);
    const auto cells = volume_blocks(mesh_);
    const std::size_t count = element_count();
    file_.print("$Elements\n{} {} {} {}\n", count_parts(faces) + count_parts(cells), count, count > 0 ? 1 : 0,
                count);
    std::size_t number = 0;
    for (const auto& [patch, box] : surfaces_)
      for (const CellBlock& block : faces) write_part(block, 2, patch, patch + 1, number);
    for (const auto& [label, box] : volumes_)
      for (const CellBlock& block : cells) write_part(block, 3, label, label, number);
    file_.print("$EndElements\n");
  }

  void write_elements_22() {
    file_.print("$Elements\n{}\n", element_count());
    std::size_t number = 0;
    const auto print_block = [&](const CellBlock& block, std::int32_t offset) {
      for (std::size_t i = 0; i < block.size(); ++i) {
        const std::int32_t tag = block.tags[i] + offset;
        file_.print("{} {} 2 {} {}", ++number, names_of(block.shape).gmsh_type, tag, tag);
        print_corners(block, i);
      }
    };
    for (const CellBlock& block : face_blocks(mesh_)) print_block(block, 1);
    for (const CellBlock& block : volume_blocks(mesh_)) print_block(block, 0);
    file_.print("$EndElements\n");
  }

  OutputFile file_;
  const MeshView& mesh_;
  Boxes volumes_;
  Boxes surfaces_;
};

}  // namespace

void write_gmsh(const std::filesystem::path& path, const MeshView& mesh, MshVersion version) {
  GmshWriter(path, mesh).write(version);
}

}  // namespace lumesh::io
