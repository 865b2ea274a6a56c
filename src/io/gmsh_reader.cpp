// Gmsh MSH, ASCII, https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format: 4.1 and 2.2.
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "cell_blocks.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "text_scanner.hpp"

namespace lumesh::io {

namespace {

/// Gmsh's element types of the first order; `corners` is 0 for those unknown to us.
struct ElementType {
  std::size_t corners = 0;
  bool is_cell = false;  ///< False: points and lines, which carry nothing for us.
  CellShape shape = CellShape::kTetrahedron;
};

ElementType element_type(std::int64_t number) {
  constexpr std::int64_t kLine = 1, kPoint = 15;
  if (number == kLine) return {2};
  if (number == kPoint) return {1};
  const ShapeNames* const names = find_shape(&ShapeNames::gmsh_type, number);
  return names == nullptr ? ElementType() : ElementType{names->corners, true, names->shape};
}

/// Physical tags of entities carry the sign of their orientation. Those of 64 bits fail later.
std::int64_t magnitude(std::int64_t tag) {
  return tag < 0 && tag != INT64_MIN ? -tag : tag;
}

/// From node tags, which may have gaps, to indices.
class NodeNumbers {
 public:
  /// False if the tag is there already.
  bool add(std::int64_t tag) {
    const auto index = static_cast<std::int64_t>(size_++);
    if (dense_ && tag == index + 1) return true;
    if (dense_) {
      for (std::int64_t i = 0; i < index; ++i) index_of_.emplace(i + 1, i);
      dense_ = false;
    }
    return index_of_.emplace(tag, index).second;
  }
  /// -1 if there is no such node.
  [[nodiscard]] std::int64_t index(std::int64_t tag) const {
    if (dense_) return tag >= 1 && tag <= static_cast<std::int64_t>(size_) ? tag - 1 : -1;
    const auto found = index_of_.find(tag);
    return found == index_of_.end() ? -1 : found->second;
  }

 private:
  std::size_t size_ = 0;
  bool dense_ = true;  ///< Tags so far are 1, 2, 3, …
  std::unordered_map<std::int64_t, std::int64_t> index_of_;
};

class GmshReader {
 public:
  explicit GmshReader(const std::filesystem::path& path) : scanner_(path), builder_(path) {}

  MixedMesh read() {
    read_format();
    while (!scanner_.at_end()) {
      const std::string section(scanner_.word());
      if (section.size() < 2 || section[0] != '$') scanner_.fail("a section should start here");
      read_section(section);
    }
    if (!has_nodes_ || !has_elements_) scanner_.fail("$Nodes or $Elements is missing");
    return builder_.finish();
  }

 private:
  void read_format() {
    if (scanner_.peek() == "$NOD")
      scanner_.fail("version 1 of the format is too old, use gmsh -format msh41");
    scanner_.expect("$MeshFormat");
    const std::string version(scanner_.word());
    if (version != "4.1" && version != "2.2" && version != "2.1" && version != "2" && version != "2.0")
      scanner_.fail("only versions 4.1 and 2.2 can be read, not \"" + version.substr(0, 20) +
                    "\", use gmsh -format msh41");
    is_41_ = version == "4.1";
    if (scanner_.integer("the file type") != 0)
      scanner_.fail("binary .msh files cannot be read, use gmsh -format msh41 without -bin");
    scanner_.integer("the size of a number");
    scanner_.expect("$EndMeshFormat");
  }

  void read_section(const std::string& section) {
    const std::string end = "$End" + section.substr(1);
    if (section == "$PhysicalNames")
      read_names();
    else if (section == "$Entities" && is_41_)
      read_entities();
    else if (section == "$Nodes")
      is_41_ ? read_nodes_41() : read_nodes_22();
    else if (section == "$Elements")
      is_41_ ? read_elements_41() : read_elements_22();
    else if (section == "$Comments")
      return builder_.set_info(info_from_json(scanner_.skip_behind(end)));
    else
      return static_cast<void>(scanner_.skip_behind(end));
    scanner_.expect(end);
  }

  void read_names() {
    const std::size_t count = scanner_.count("the number of names", 3);
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t dimension = scanner_.integer("a dimension");
      const std::int64_t tag = scanner_.integer("a physical tag");
      std::string name = scanner_.quoted("a physical name");
      if (tag < INT32_MIN || tag > INT32_MAX) scanner_.fail("a physical tag does not fit into 32 bits");
      if (dimension == 2)
        builder_.name_patch(tag, std::move(name));
      else if (dimension == 3)
        builder_.name_label(static_cast<Label>(tag), std::move(name));
    }
  }

  void read_entities() {
    std::array<std::size_t, 4> counts{};
    for (std::size_t& count : counts) count = scanner_.count("a number of entities", 4);
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts.at(static_cast<std::size_t>(dimension)); ++i) read_entity(dimension);
  }

  void read_entity(int dimension) {
    const std::int64_t tag = scanner_.integer("an entity's tag");
    for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) scanner_.word();  // where it is
    const std::size_t physicals = scanner_.count("the number of physical tags", 1);
    for (std::size_t i = 0; i < physicals; ++i) {
      const std::int64_t physical = scanner_.integer("a physical tag");
      if (i == 0) physical_of_[{dimension, tag}] = magnitude(physical);
    }
    if (dimension == 0) return;
    const std::size_t boundary = scanner_.count("the number of bounding entities", 1);
    for (std::size_t i = 0; i < boundary; ++i) scanner_.integer("a bounding entity");
  }

  /// The first physical tag, or the entity's own where there is none.
  [[nodiscard]] std::int64_t physical_of(std::int64_t dimension, std::int64_t entity) const {
    const auto found = physical_of_.find({dimension, entity});
    return found == physical_of_.end() ? entity : found->second;
  }

  void add_node_number(std::int64_t tag) {
    if (!nodes_.add(tag)) scanner_.fail("node " + std::to_string(tag) + " is there twice");
  }

  void read_point() {
    Vec3 point;
    for (double& x : point) x = scanner_.real("a coordinate");
    builder_.add_point(point);
  }

  void read_nodes_41() {
    has_nodes_ = true;
    const std::size_t blocks = scanner_.count("the number of node blocks", 4);
    for (int i = 0; i < 3; ++i) scanner_.integer("the numbers of nodes");
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = scanner_.integer("an entity's dimension");
      scanner_.integer("an entity's tag");
      const bool parametric = scanner_.integer("the parametric flag") != 0;
      const std::size_t count = scanner_.count("the number of nodes of a block", 4);
      if (dimension < 0 || dimension > 3) scanner_.fail("an entity's dimension is not 0 to 3");
      for (std::size_t i = 0; i < count; ++i) add_node_number(scanner_.integer("a node's tag"));
      for (std::size_t i = 0; i < count; ++i) {
        read_point();
        for (std::int64_t k = 0; parametric && k < dimension; ++k) scanner_.real("a parametric coordinate");
      }
    }
  }

  void read_nodes_22() {
    has_nodes_ = true;
    const std::size_t count = scanner_.count("the number of nodes", 4);
    for (std::size_t i = 0; i < count; ++i) {
      add_node_number(scanner_.integer("a node's number"));
      read_point();
    }
  }

  void read_corners(const ElementType& type, std::int64_t tag) {
    std::array<std::int64_t, 8> corners{};
    for (std::size_t k = 0; k < type.corners; ++k) {
      const std::int64_t node = scanner_.integer("a node's number");
      corners[k] = nodes_.index(node);
      if (corners[k] < 0)
        scanner_.fail("an element refers to node " + std::to_string(node) + ", which is not there");
    }
    if (type.is_cell) builder_.add_cell(type.shape, {corners.data(), type.corners}, tag);
  }

  ElementType read_type() {
    const std::int64_t number = scanner_.integer("an element's type");
    const ElementType type = element_type(number);
    if (type.corners == 0)
      scanner_.fail("elements of Gmsh type " + std::to_string(number) +
                    " are not known to lumesh, use first order (gmsh -order 1)");
    return type;
  }

  void read_elements_41() {
    has_elements_ = true;
    const std::size_t blocks = scanner_.count("the number of element blocks", 4);
    for (int i = 0; i < 3; ++i) scanner_.integer("the numbers of elements");
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = scanner_.integer("an entity's dimension");
      const std::int64_t entity = scanner_.integer("an entity's tag");
      const ElementType type = read_type();
      const std::size_t count = scanner_.count("the number of elements of a block", type.corners + 1);
      const std::int64_t tag = physical_of(dimension, entity);
      for (std::size_t i = 0; i < count; ++i) {
        scanner_.integer("an element's tag");
        read_corners(type, tag);
      }
    }
  }

  void read_elements_22() {
    has_elements_ = true;
    const std::size_t count = scanner_.count("the number of elements", 3);
    for (std::size_t i = 0; i < count; ++i) {
      scanner_.integer("an element's number");
      const ElementType type = read_type();
      const std::size_t tags = scanner_.count("the number of tags", 1);
      std::int64_t physical = 0;
      for (std::size_t t = 0; t < tags; ++t) {
        const std::int64_t tag = scanner_.integer("a tag");
        if (t == 0 || (t == 1 && physical == 0)) physical = tag;
      }
      read_corners(type, physical);
    }
  }

  TextScanner scanner_;
  MeshBuilder builder_;
  NodeNumbers nodes_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> physical_of_;
  bool is_41_ = true;
  bool has_nodes_ = false;
  bool has_elements_ = false;
};

}  // namespace

MixedMesh read_gmsh(const std::filesystem::path& path) {
  return GmshReader(path).read();
}

}  // namespace lumesh::io
