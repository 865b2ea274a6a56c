// Legacy VTK of versions 1.0 to 5.1, text or binary, also gzipped.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "label_arrays.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/trimmed.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "metric_tensors.hpp"
#include "number_of_bits.hpp"
#include "point_arrays.hpp"
#include "polygons.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

constexpr const char* kOtherData = "holds neither an unstructured grid nor PolyData";

class LegacyReader {
 public:
  explicit LegacyReader(const std::filesystem::path& path) : path_(path), content_(unpacked_file(path)) {}

  /// @param patch_array  As add_polygons() takes it; empty for unstructured grids.
  MixedMesh run(const std::string& patch_array, const Context& context) {
    read_header();
    if (dataset_ == "POLYDATA") return run_for_polygons(patch_array, context);
    if (dataset_ != "UNSTRUCTURED_GRID") fail(kOtherData);
    if (!patch_array.empty()) fail("is a mesh, and patches by an array are read of surfaces");
    read_sections();
    assemble();
    return std::move(mesh_);
  }

  /// Reads the points of an unstructured grid or of PolyData, which begin with them.
  MixedMesh run_for_points() {
    read_header();
    if (dataset_ == "UNSTRUCTURED_GRID") {
      read_sections();
    } else if (dataset_ == "POLYDATA") {
      std::string word = next();
      for (; !word.empty() && word != "POINTS"; word = next()) read_section(word);
      if (!word.empty()) read_section(word);
    } else {
      fail(kOtherData);
    }
    assemble_points();
    restore_info();
    return std::move(mesh_);
  }

  /// The same with the arrays on the points.
  PointData run_for_point_data() {
    read_header();
    if (dataset_ != "UNSTRUCTURED_GRID" && dataset_ != "POLYDATA") fail(kOtherData);
    keeps_point_arrays_ = true;
    read_sections();
    assemble_points();
    restore_info();
    PointData data;
    data.points = std::move(mesh_.points);
    data.info = std::move(mesh_.info);
    for (const PointArray& array : point_arrays_)
      keep_point_array(path_, array.name, array.values, array.components, data);
    return data;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { io::fail(path_, what); }

  MixedMesh run_for_polygons(const std::string& patch_array, const Context& context) {
    read_sections();
    assemble_points();
    restore_info();
    CellArrays arrays;
    for (const auto& [name, values] : arrays_)
      if (!name.starts_with("lumesh_")) arrays.names.push_back(name);
    arrays.find = [&](const std::string& name) -> std::optional<std::vector<std::int64_t>> {
      const auto found = arrays_.find(name);
      if (found == arrays_.end()) return std::nullopt;
      return integers(found->second);
    };
    add_polygons(path_, polygons_, arrays, patch_array, context, mesh_);
    return std::move(mesh_);
  }
  [[nodiscard]] std::vector<std::int64_t> integers(const std::vector<double>& values) const {
    std::vector<std::int64_t> result;
    result.reserve(values.size());
    for (const double value : values) {
      if (!(std::abs(value) < 1e15) || value != std::floor(value))
        fail(fmt::format("{} stands where a whole number belongs", value));
      result.push_back(static_cast<std::int64_t>(value));
    }
    return result;
  }

  std::string_view line() {
    const std::size_t end = std::min(content_.find('\n', at_), content_.size());
    const std::string_view text = std::string_view(content_).substr(at_, end - at_);
    at_ = std::min(end + 1, content_.size());
    return text;
  }
  std::string next() {
    constexpr std::string_view kSpace = " \t\r\n";
    at_ = content_.find_first_not_of(kSpace, at_);
    if (at_ == std::string::npos) {
      at_ = content_.size();
      return {};
    }
    const std::size_t end = std::min(content_.find_first_of(kSpace, at_), content_.size());
    std::string word = content_.substr(at_, end - at_);
    at_ = end;
    return word;
  }
  std::size_t next_count() {
    const std::string word = next();
    const std::optional<std::size_t> value = parse_number<std::size_t>(word);
    if (!value || *value > content_.size())
      fail(fmt::format("'{}' stands where a count belongs; the file is cut off or damaged",
                       word.substr(0, 20)));
    return *value;
  }

  void read_header() {
    if (!content_.starts_with("# vtk DataFile")) fail("not a legacy VTK file");
    line();
    line();
    const std::string kind = next();
    if (kind != "ASCII" && kind != "BINARY") fail("neither ASCII nor BINARY");
    binary_ = kind == "BINARY";
    if (next() != "DATASET") fail("holds no data set");
    dataset_ = next();
  }

  void read_sections() {
    for (std::string word = next(); !word.empty(); word = next()) read_section(word);
  }

  static std::size_t bytes_of(const std::string& type) {
    static const std::map<std::string, std::size_t> kBytes = {
        {"char", 1},           {"unsigned_char", 1}, {"signed_char", 1},   {"short", 2},
        {"unsigned_short", 2}, {"int", 4},           {"float", 4},         {"unsigned_int", 4},
        {"vtktypeint32", 4},   {"long", 8},          {"unsigned_long", 8}, {"double", 8},
        {"vtktypeint64", 8},   {"vtktypeuint64", 8}, {"vtkidtype", 4}};
    const auto found = kBytes.find(type);
    return found == kBytes.end() ? 0 : found->second;
  }

  /// `count` numbers of a type, as doubles (exact for the integers that occur).
  std::vector<double> numbers(std::string type, std::size_t count) {
    type = lower_case(std::move(type));
    const std::size_t size = bytes_of(type);
    if (size == 0) fail(fmt::format("holds an array of the unknown type {}", type.substr(0, 20)));
    if (count > content_.size()) fail("is cut off");
    std::vector<double> out(count);
    if (!binary_) {
      for (double& value : out) {
        const std::string word = next();
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc()) fail("is cut off, or holds text where a number belongs");
      }
      return out;
    }
    line();  // the rest of the header line
    if (count > (content_.size() - at_) / size) fail("is cut off");
    for (double& value : out) {
      value = number_at(content_.data() + at_, type, size);
      at_ += size;
    }
    return out;
  }

  static double number_at(const char* bytes, const std::string& type, std::size_t size) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) bits = bits << 8 | static_cast<unsigned char>(bytes[i]);
    const bool is_unsigned = type.starts_with("unsigned") || type == "vtktypeuint64";
    return number_of_bits(bits, size, type == "double" || type == "float", !is_unsigned);
  }

  /// A number that an array index or a type can be; readers of damaged files meet infinities.
  [[nodiscard]] std::size_t whole(double value) const {
    if (!(value >= 0 && value < 1e15)) fail(fmt::format("{} stands where a whole number belongs", value));
    return static_cast<std::size_t>(value);
  }

  void read_section(const std::string& word) {
    if (word == "POINTS") {
      const std::size_t count = next_count();
      points_ = numbers(next(), 3 * count);
    } else if (word == "CELLS") {
      read_cells();
    } else if (is_poly_cells(word)) {
      read_poly_cells(word);
    } else if (word == "CELL_TYPES") {
      types_ = numbers("int", next_count());
    } else if (word == "CELL_DATA") {
      tuples_ = next_count();
      part_ = Part::kCells;
    } else if (word == "POINT_DATA") {
      tuples_ = next_count();
      part_ = Part::kPoints;
    } else if (word == "FIELD") {
      next();
      read_field(next_count());
    } else if (word == "SCALARS") {
      read_scalars();
    } else if (word == "VECTORS" || word == "NORMALS") {
      read_attribute(3);
    } else if (word == "TENSORS") {
      read_attribute(9);
    } else if (word == "TENSORS6") {
      read_attribute(6);
    } else if (word == "METADATA") {
      skip_metadata();
    } else if (!skip_section(word)) {
      fail(fmt::format("holds the unknown section '{}'", word.substr(0, 20)));
    }
  }

  /// Attributes that nothing is made of. @return False if it is none of them.
  bool skip_section(const std::string& word) {
    if (word == "GLOBAL_IDS" || word == "PEDIGREE_IDS" || word == "EDGE_FLAGS") {
      next();
      numbers(next(), tuples_);
    } else if (word == "TEXTURE_COORDINATES") {
      next();
      const std::size_t components = next_count();
      skip_tuples(next(), tuples_, components);
    } else if (word == "COLOR_SCALARS") {
      next();
      skip_tuples(binary_ ? "unsigned_char" : "float", tuples_, next_count());
    } else if (word == "LOOKUP_TABLE") {
      next();
      skip_tuples(binary_ ? "unsigned_char" : "float", next_count(), 4);
    } else {
      return false;
    }
    return true;
  }
  /// Texts are lines, or have their length before them, whose first two bits say how many bytes it takes.
  void skip_texts(std::size_t count) {
    line();  // the rest of the header line
    for (std::size_t i = 0; i < count; ++i) {
      if (at_ >= content_.size()) fail("is cut off");
      if (!binary_) {
        line();
        continue;
      }
      const unsigned first = static_cast<unsigned char>(content_[at_]);
      const std::size_t bytes = std::size_t{8} >> (first >> 6U);
      if (bytes > content_.size() - at_) fail("is cut off");
      std::uint64_t length = first & 0x3FU;
      for (std::size_t k = 1; k < bytes; ++k)
        length = length << 8U | static_cast<unsigned char>(content_[at_ + k]);
      at_ += bytes;
      if (length > content_.size() - at_) fail("is cut off");
      at_ += length;
    }
  }
  void skip_tuples(const std::string& type, std::size_t tuples, std::size_t components) {
    if (components > 0 && tuples > content_.size() / components) fail("is cut off");
    numbers(type, tuples * components);
  }

  [[nodiscard]] bool is_poly_cells(const std::string& word) const {
    return dataset_ == "POLYDATA" &&
           (word == "LINES" || word == "VERTICES" || word == "POLYGONS" || word == "TRIANGLE_STRIPS");
  }

  void read_poly_cells(const std::string& word) {
    offsets_.clear();
    connectivity_.clear();
    read_cells();
    const std::size_t cells = std::max<std::size_t>(offsets_.size(), 1) - 1;
    if (word == "LINES" || word == "VERTICES") {
      polygons_.cells_before += cells;
      return;
    }
    CellCorners& all = word == "TRIANGLE_STRIPS" ? polygons_.strips : polygons_.polygons;
    all.corners = integers(connectivity_);
    for (std::size_t c = 0; c < cells; ++c) all.ends.push_back(static_cast<std::int64_t>(offsets_[c + 1]));
  }

  void read_cells() {
    const std::size_t count = next_count();
    const std::size_t words = next_count();
    const std::size_t before = at_;
    if (next() == "OFFSETS") {
      const std::vector<double> offsets = numbers(next(), count);
      if (next() != "CONNECTIVITY") fail("has cell offsets without a connectivity");
      connectivity_ = numbers(next(), words);
      for (const double o : offsets) offsets_.push_back(whole(o));
      return;
    }
    at_ = before;
    const std::vector<double> mixed = numbers("int", words);
    offsets_.push_back(0);
    for (std::size_t i = 0; i < mixed.size();) {
      const std::size_t corners = whole(mixed[i]);
      if (corners == 0 || corners > mixed.size() - i - 1) fail("its cells are damaged");
      connectivity_.insert(connectivity_.end(), mixed.begin() + static_cast<std::ptrdiff_t>(i + 1),
                           mixed.begin() + static_cast<std::ptrdiff_t>(i + 1 + corners));
      offsets_.push_back(connectivity_.size());
      i += corners + 1;
    }
  }

  /// VTK's notes on an array, up to an empty line.
  void skip_metadata() {
    line();
    while (at_ < content_.size() && line().find_first_not_of(" \t\r") != std::string_view::npos) {
    }
  }

  void read_field(std::size_t arrays) {
    for (std::size_t a = 0; a < arrays; ++a) {
      std::string name = next();
      while (name == "METADATA") {
        skip_metadata();
        name = next();
      }
      const std::size_t components = next_count();
      const std::size_t tuples = next_count();
      const std::string type = next();
      if (components > 0 && tuples > content_.size() / components) fail("is cut off");
      if (type == "string") {
        skip_texts(components * tuples);
        continue;
      }
      keep_array(name, components, numbers(type, components * tuples));
    }
  }

  /// Vectors and tensors; nothing of cells is wanted.
  void read_attribute(std::size_t components) {
    const std::string name = next();
    const std::string type = next();
    std::vector<double> values = numbers(type, tuples_ * components);
    if (part_ == Part::kPoints) keep_array(name, components, std::move(values));
  }

  void read_scalars() {
    const std::string name = next();
    const std::string type = next();
    std::size_t components = 1;
    std::string word = next();
    if (word != "LOOKUP_TABLE") {
      components = word == "2" ? 2 : (word == "3" ? 3 : (word == "4" ? 4 : 1));
      word = next();
    }
    if (word != "LOOKUP_TABLE") fail("has scalars without a lookup table");
    next();
    keep_array(name, components, numbers(type, tuples_ * components));
  }

  void keep_array(const std::string& name, std::size_t components, std::vector<double> values) {
    if (keeps_point_arrays_ && part_ == Part::kPoints) {
      if (components == 1 || components == 3) point_arrays_.push_back({name, components, std::move(values)});
    } else if (part_ == Part::kPoints && name == "metric") {
      metric_ = std::move(values);
      metric_components_ = components;
    } else if (part_ == Part::kPoints && name == "size" && components == 1) {
      mesh_.sizes_mm = std::move(values);
    } else if (part_ == Part::kCells || name.starts_with("lumesh_")) {
      arrays_.emplace(name, std::move(values));
    }
  }

  void assemble_points() {
    for (std::size_t i = 0; i + 2 < points_.size(); i += 3) {
      mesh_.points.emplace_back(points_[i], points_[i + 1], points_[i + 2]);
      if (!mesh_.points.back().allFinite()) fail("point " + std::to_string(i / 3) + " is not finite");
    }
  }

  void assemble() {
    assemble_points();
    if (metric_components_)
      mesh_.metric = metric_from_vtk(path_, metric_, *metric_components_, mesh_.points.size());
    if (!mesh_.sizes_mm.empty() && mesh_.sizes_mm.size() != mesh_.points.size()) fail(kFewSizes);
    if (offsets_.size() != types_.size() + 1) fail("does not hold as many cell types as cells");
    const std::vector<double>* labels = find_labels();
    for (std::size_t c = 0; c < types_.size(); ++c) {
      if (offsets_[c] > offsets_[c + 1] || offsets_[c + 1] > connectivity_.size()) fail(kBadOffsets);
      const double label = labels == nullptr ? 1 : (*labels)[c];
      if (!(std::abs(label) < 2e9)) fail("a label is too large");
      const auto type = static_cast<std::int64_t>(whole(types_[c]));
      if (is_face(type)) continue;  // Faces of other programs are found anew.
      add_vtk_cell(path_, type,
                   std::span<const double>(connectivity_).subspan(offsets_[c], offsets_[c + 1] - offsets_[c]),
                   static_cast<Label>(label), mesh_);
    }
    restore_faces();
  }

  [[nodiscard]] const std::vector<double>* find_labels() const {
    for (const char* name : kLabelArrays) {
      const auto found = arrays_.find(name);
      if (found != arrays_.end() && found->second.size() == types_.size()) return &found->second;
    }
    return nullptr;
  }

  template <std::size_t N>
  void restore(std::size_t block, std::vector<Cell<N>>& faces, std::vector<std::int32_t>& patches) {
    const auto corners = arrays_.find(kFaceArrays[block]);
    const auto tags = arrays_.find(kFacePatchArrays[block]);
    if (corners == arrays_.end() || tags == arrays_.end()) return;
    take_vtk_faces(path_, corners->second, tags->second, kFacePatchArrays[block],
                   std::ssize(mesh_.info.patches), mesh_.points.size(), faces, patches);
  }

  /// @return False if the file has none.
  bool restore_info() {
    const auto info = arrays_.find("lumesh_info");
    if (info == arrays_.end()) return false;
    std::string text;
    for (const double c : info->second) text.push_back(static_cast<char>(whole(c)));
    mesh_.info = info_from_json(text);
    return true;
  }

  void restore_faces() {
    if (!restore_info()) return;
    restore(0, mesh_.triangles, mesh_.triangle_patches);
    restore(1, mesh_.quadrilaterals, mesh_.quadrilateral_patches);
  }

  const std::filesystem::path& path_;
  std::string content_;
  std::size_t at_ = 0;
  bool binary_ = false;
  std::string dataset_;
  enum class Part : std::uint8_t { kDataset, kCells, kPoints };  ///< What data arrays belong to.
  Part part_ = Part::kDataset;
  std::size_t tuples_ = 0;
  std::vector<double> points_, connectivity_, types_, metric_;
  std::optional<std::size_t> metric_components_;  ///< None if there is no metric.
  std::vector<std::size_t> offsets_;
  Polygons polygons_;
  std::map<std::string, std::vector<double>> arrays_;
  struct PointArray {
    std::string name;
    std::size_t components;
    std::vector<double> values;
  };
  bool keeps_point_arrays_ = false;  ///< Instead of those that are known.
  std::vector<PointArray> point_arrays_;
  MixedMesh mesh_;
};

}  // namespace

MixedMesh read_legacy_vtk(const std::filesystem::path& path) {
  return read_legacy_vtk_by(path, "", Context());
}

MixedMesh read_legacy_vtk_by(const std::filesystem::path& path, const std::string& patch_array,
                             const Context& context) {
  return LegacyReader(path).run(patch_array, context);
}

MixedMesh read_legacy_vtk_points(const std::filesystem::path& path) {
  return LegacyReader(path).run_for_points();
}

PointData read_legacy_vtk_point_data(const std::filesystem::path& path) {
  return LegacyReader(path).run_for_point_data();
}

}  // namespace lumesh::io
