// PLY of Stanford: points and polygons of a surface, text or binary; no place for patches that programs agree
// on.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <string>
#include <vector>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"
#include "number_of_bits.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

enum class PlyForm : std::uint8_t { kText, kLittleEndian, kBigEndian };

struct PlyType {
  std::array<std::string_view, 2> names;
  std::size_t bytes;
  bool is_real, is_signed;
};
constexpr auto kPlyTypes = std::to_array<PlyType>({{{"char", "int8"}, 1, false, true},
                                                   {{"uchar", "uint8"}, 1, false, false},
                                                   {{"short", "int16"}, 2, false, true},
                                                   {{"ushort", "uint16"}, 2, false, false},
                                                   {{"int", "int32"}, 4, false, true},
                                                   {{"uint", "uint32"}, 4, false, false},
                                                   {{"float", "float32"}, 4, true, true},
                                                   {{"double", "float64"}, 8, true, true}});

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count_type = nullptr;  ///< Type of the number of entries in lists.
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path) : path_(path), content_(unpacked_file(path)) {}

  MixedMesh read() {
    read_header();
    bool has_faces = false;
    for (const PlyElement& element : elements_) {
      if (element.name == "vertex")
        read_points(element);
      else if (element.name == "face")
        has_faces = read_faces(element);
      else if (element.name == "tristrips")
        fail("holds strips of triangles; write its faces as triangles");
      else
        skip(element);
    }
    if (!has_faces) fail("holds no polygon");
    // What a header does not declare would be left out, and the hole closed.
    if (content_.find_first_not_of(std::string_view(" \t\r\n\0", 5), at_) != std::string::npos)
      fail("holds more than its header declares; write the file again");
    builder_.name_patch(0, kWallName);
    return builder_.finish();
  }

 private:
  [[noreturn]] void fail(std::string_view what) const { io::fail(path_, what); }

  std::string_view header_line() {
    const std::size_t end = content_.find('\n', at_);
    if (end == std::string::npos) fail("is cut off in its header; write the file again");
    std::string_view line = std::string_view(content_).substr(at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  static std::vector<std::string> words_of(std::string_view line) {
    std::istringstream words{std::string(line)};
    return {std::istream_iterator<std::string>(words), {}};
  }

  void read_header() {
    if (header_line() != "ply") fail("the first word is not ply");
    bool has_format = false;
    for (std::vector<std::string> words = words_of(header_line()); words.empty() || words[0] != "end_header";
         words = words_of(header_line())) {
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "format" && words.size() > 1) {
        form_ = form_of(words[1]);
        has_format = true;
      } else if (words[0] == "element" && words.size() == 3) {
        const auto count = parse_number<std::size_t>(words[2]);
        if (!count) fail_in_header(words);
        elements_.push_back({words[1], *count, {}});
      } else if (words[0] == "property" && !elements_.empty()) {
        elements_.back().properties.push_back(property_of(words));
      } else {
        fail_in_header(words);
      }
    }
    if (!has_format) fail("does not say its format; write the file again");
  }
  [[noreturn]] void fail_in_header(const std::vector<std::string>& words) const {
    fail(fmt::format("its header has the unknown line '{:.40}'", fmt::format("{}", fmt::join(words, " "))));
  }
  [[nodiscard]] PlyForm form_of(const std::string& word) const {
    if (word == "ascii") return PlyForm::kText;
    if (word == "binary_little_endian") return PlyForm::kLittleEndian;
    if (word == "binary_big_endian") return PlyForm::kBigEndian;
    fail(fmt::format("has the unknown format '{:.40}'", word));
  }
  [[nodiscard]] const PlyType* type_of(const std::string& word) const {
    for (const PlyType& type : kPlyTypes)
      if (std::ranges::find(type.names, word) != type.names.end()) return &type;
    fail(fmt::format("has a property of the unknown type '{:.40}'", word));
  }
  [[nodiscard]] PlyProperty property_of(const std::vector<std::string>& words) const {
    if (words.size() == 5 && words[1] == "list") return {words[4], type_of(words[3]), type_of(words[2])};
    if (words.size() == 3) return {words[2], type_of(words[1]), nullptr};
    fail_in_header(words);
  }

  double number(const PlyType& type) {
    if (form_ == PlyForm::kText) return number_in_text();
    if (type.bytes > content_.size() - at_) fail("is cut off; write the file again");
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.bytes; ++i) {
      const std::size_t place = form_ == PlyForm::kBigEndian ? i : type.bytes - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(content_[at_ + place]);
    }
    at_ += type.bytes;
    return number_of_bits(bits, type.bytes, type.is_real, type.is_signed);
  }
  double number_in_text() {
    at_ = std::min(content_.find_first_not_of(" \t\r\n", at_), content_.size());
    const std::size_t end = std::min(content_.find_first_of(" \t\r\n", at_), content_.size());
    double value = 0;
    const char *const first = content_.data() + at_, *const last = content_.data() + end;
    const auto [stop, error] = std::from_chars(first, last, value);
    if (error != std::errc() || stop != last)
      fail("is cut off, or holds text where a number belongs; write the file again");
    at_ = end;
    return value;
  }

  std::size_t list_size(const PlyProperty& property) {
    const double count = number(*property.count_type);
    if (!(count >= 0 && count <= static_cast<double>(content_.size() - at_))) fail("a list is damaged");
    return static_cast<std::size_t>(count);
  }
  void skip(const PlyProperty& property) {
    const std::size_t count = property.count_type == nullptr ? 1 : list_size(property);
    for (std::size_t i = 0; i < count; ++i) number(*property.type);
  }
  void skip(const PlyElement& element) {
    for (std::size_t i = 0; i < element.count && !element.properties.empty(); ++i)
      for (const PlyProperty& property : element.properties) skip(property);
  }

  void read_points(const PlyElement& element) {
    std::array<const PlyProperty*, 3> axes = {};
    for (const PlyProperty& property : element.properties)
      if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z' &&
          property.count_type == nullptr)
        axes[static_cast<std::size_t>(property.name[0] - 'x')] = &property;
    if (std::ranges::find(axes, nullptr) != axes.end()) fail("its points have no x, y and z");
    for (std::size_t i = 0; i < element.count; ++i) {
      Vec3 point;
      for (const PlyProperty& property : element.properties) {
        const auto axis = std::ranges::find(axes, &property) - axes.begin();
        if (axis < 3)
          point[axis] = number(*property.type);
        else
          skip(property);
      }
      builder_.add_point(point);
    }
  }

  bool read_faces(const PlyElement& element) {
    const auto is_corners = [](const PlyProperty& p) {
      return p.count_type != nullptr && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    if (std::ranges::none_of(element.properties, is_corners)) fail("its faces have no vertex_indices");
    for (std::size_t i = 0; i < element.count; ++i)
      for (const PlyProperty& property : element.properties) {
        if (is_corners(property))
          read_polygon(property);
        else
          skip(property);
      }
    return element.count > 0;
  }
  void read_polygon(const PlyProperty& property) {
    std::vector<std::int64_t> corners(list_size(property));
    for (std::int64_t& corner : corners) {
      const double value = number(*property.type);
      if (!(value >= 0 && value < 1e15)) fail("a corner of a polygon is damaged; write the file again");
      corner = static_cast<std::int64_t>(value);
    }
    if (corners.size() < 3) fail(kFewCorners);
    builder_.add_polygon(corners, 0);
  }

  const std::filesystem::path& path_;
  std::string content_;
  std::size_t at_ = 0;
  PlyForm form_ = PlyForm::kText;
  std::vector<PlyElement> elements_;
  MeshBuilder builder_{path_};
};

}  // namespace

MixedMesh read_ply(const std::filesystem::path& path) {
  return PlyReader(path).read();
}

}  // namespace lumesh::io
