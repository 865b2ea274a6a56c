// The voxels of the NRRD files that most programs write, http://teem.sourceforge.net/nrrd/format.html.
#include <libdeflate.h>

#include <array>
#include <bit>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "raw_image.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

/// Whether a line of the header, in small letters, is of the field.
bool is_field(std::string_view line, std::string_view field) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.substr(colon).starts_with(":=")) return false;
  std::string name(line.substr(0, colon));
  std::erase(name, ' ');
  return name == field;
}

bool holds_number(std::string_view text) {
  return text.find_first_of("0123456789") != std::string_view::npos;
}

bool holds(std::string_view line, std::string_view word) {
  return line.find(word) != std::string_view::npos;
}

/// A comment, a note "key:=value" or what the image is of.
bool is_free_text(std::string_view line) {
  const std::size_t colon = line.find(':');
  return line.starts_with('#') || line.starts_with("content:") ||
         (colon != std::string_view::npos && line.substr(colon).starts_with(":="));
}

/// The unit of length in a line such as: units: "" "m" "m" "m", else the first word; empty without any. All
/// of them where they differ, which no length has.
std::string unit_of(std::string_view line) {
  std::string first, found;
  for (std::size_t begin = line.find('"'); begin != std::string_view::npos;) {
    const std::size_t end = line.find('"', begin + 1);
    if (end == std::string_view::npos) break;
    const std::string unit = unit_called(trimmed(line.substr(begin + 1, end - begin - 1)));
    if (unit_in_mm(unit) > 0 && found.empty())
      found = unit;
    else if (unit_in_mm(unit) > 0 && unit != found)
      return found + ", " + unit;
    if (first.empty()) first = unit;
    begin = line.find('"', end + 1);
  }
  return found.empty() ? first : found;
}

/// The vectors of a line such as: space directions: none (0,1,0) (0,0,-1) (1.5,0,0)
std::vector<Vec3> vectors_of(const std::string& line) {
  std::vector<Vec3> vectors;
  for (std::size_t at = line.find('('); at != std::string::npos; at = line.find('(', at + 1)) {
    Vec3& v = vectors.emplace_back(Vec3::Zero());
    const char* from = line.c_str() + at;
    for (int i = 0; i < 3 && (*from == '(' || *from == ','); ++i) {
      char* end = nullptr;
      v[i] = std::strtod(from + 1, &end);
      from = end;
    }
  }
  return vectors;
}

/// Signs that turn coordinates of a space into LPS; none for spaces of no known sides.
std::optional<Vec3> factors_to_lps(std::string_view space) {
  if (space.ends_with("-time")) space.remove_suffix(5);
  if (space.size() == 4 && space.ends_with('t')) space.remove_suffix(1);
  if (space == "lps" || space == "left-posterior-superior") return Vec3(1, 1, 1);
  if (space == "las" || space == "left-anterior-superior") return Vec3(1, -1, 1);
  if (space == "ras" || space == "right-anterior-superior") return Vec3(-1, -1, 1);
  return std::nullopt;
}

/// Whether a text stands for names of files by their numbers, such as "slice%03d.raw".
bool is_pattern(std::string_view text) {
  std::size_t at = text.find('%');
  if (at == std::string_view::npos) return false;
  at = text.find_first_not_of("0123456789", at + 1);
  return at != std::string_view::npos && text[at] == 'd';
}

/// How a file keeps its voxels, by its header.
struct NrrdPacking {
  bool is_gzip = false;
  bool is_one_stream = true;   ///< Behind the header, all of it voxels.
  bool has_own_order = false;  ///< Voxels are in this machine's byte order.
  std::streamoff header_bytes = 0;
  int skipped_lines = 0;        ///< Before what is packed.
  std::vector<fs::path> files;  ///< That hold the voxels; empty if they follow the header.
};

/// What stands behind the colon of a field, without blanks around.
std::string_view field_value(std::string_view line) {
  line.remove_prefix(line.find(':') + 1);
  return trimmed(line);
}

/// Texts of a field, one per axis: words, or vectors in brackets.
std::vector<std::string> values_of(std::string_view text) {
  std::string joined;
  bool is_vector = false;
  for (const char c : text) {
    if (c == '(' || c == ')') is_vector = c == '(';
    if (is_vector && (c == ' ' || c == '\t')) continue;
    joined += c;
    if (c == ')') joined += ' ';
  }
  std::istringstream in(joined);
  return {std::istream_iterator<std::string>(in), {}};
}

/// Whether an axis is one of the grid rather than of the values of a voxel, by its kind.
bool is_of_grid(const std::string& kind) {
  return kind == "domain" || kind == "space" || kind == "time" || kind == "none" || kind == "???";
}

/// Which axes of the grid have a spacing: "nan" stands for one that is not known.
std::array<bool, 3> axes_with_spacing(std::span<const std::string> spacings,
                                      std::span<const std::string> kinds) {
  std::array<bool, 3> has_spacing = kNoAxis;
  std::size_t axis = 0;
  for (std::size_t i = 0; i < spacings.size() && axis < has_spacing.size(); ++i) {
    if (i < kinds.size() && !is_of_grid(kinds[i])) continue;
    has_spacing.at(axis++) = holds_number(spacings[i]);
  }
  return has_spacing;
}

NrrdPacking packing_of(const fs::path& path, std::istream& in, std::size_t voxel_bytes) {
  NrrdPacking packing;
  packing.has_own_order = voxel_bytes == 1;
  bool lists_files = false;
  std::string text;
  while (std::getline(in, text)) {
    const std::string_view line = trimmed(text, "\r");
    const std::string small = lower_case(std::string(line));
    if (line.empty()) break;
    if (lists_files) packing.files.push_back(path.parent_path() / line);
    if (is_field(small, "datafile")) {
      lists_files = field_value(small).starts_with("list");
      if (!lists_files) packing.files.push_back(path.parent_path() / field_value(line));
    }
    if (is_field(small, "lineskip"))
      packing.skipped_lines = std::atoi(std::string(field_value(small)).c_str());
    if (is_field(small, "datafile") || is_field(small, "lineskip") || is_field(small, "byteskip"))
      packing.is_one_stream = false;
    if (is_field(small, "encoding")) packing.is_gzip = holds(small, "gz");
    if (is_field(small, "endian"))
      packing.has_own_order |= holds(small, std::endian::native == std::endian::little ? "little" : "big");
  }
  packing.header_bytes = in ? static_cast<std::streamoff>(in.tellg()) : 0;
  return packing;
}

}  // namespace

NrrdNotes nrrd_notes(const fs::path& path) {
  constexpr std::size_t kLongestText = 8000, kLongestField = 500;  // Teem's messages quote fields.
  std::ifstream in(path, std::ios::binary);
  NrrdNotes notes;
  std::vector<Vec3> axes;
  std::vector<std::string> spacings, kinds;
  std::optional<Vec3> to_lps;
  bool has_space_units = false;  // Those of `units` come after them.
  std::string text;
  while (std::getline(in, text) && !text.empty() && text != "\r") {
    if (text.size() > (is_free_text(text) ? kLongestText : kLongestField))
      fail(path, "has a damaged header (a very long line); save it again");
    text = lower_case(std::string(trimmed(text, "\r")));
    if (is_field(text, "spacings") || is_field(text, "spacedirections"))
      spacings = values_of(field_value(text));
    if (is_field(text, "kinds")) kinds = values_of(field_value(text));
    if (is_field(text, "spacedirections")) axes = vectors_of(text);
    if (is_field(text, "space")) {
      to_lps = factors_to_lps(field_value(text));
      notes.space_without_sides = to_lps ? "" : field_value(text);
    }
    const bool is_of_space = is_field(text, "spaceunits");
    if (is_of_space || (is_field(text, "units") && !has_space_units)) notes.unit = unit_of(text);
    has_space_units = has_space_units || is_of_space;
    if (is_field(text, "datafile") && is_pattern(text))
      fail(path, "keeps its voxels in files named by a pattern; save it as one .nrrd file");
  }
  notes.has_spacing = axes_with_spacing(spacings, kinds);
  if (to_lps) notes.axes = std::move(axes), notes.to_lps = *to_lps;
  return notes;
}

bool unpack_nrrd(const fs::path& path, std::size_t voxel_bytes, std::span<std::byte> voxels) {
  std::ifstream in(path, std::ios::binary);
  const NrrdPacking packing = packing_of(path, in, voxel_bytes);
  if (!packing.is_gzip || !packing.is_one_stream || !packing.has_own_order || !in) return false;
  const std::vector<char> packed((std::istreambuf_iterator<char>(in)), {});
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!inflater) return false;
  return libdeflate_gzip_decompress(inflater.get(), packed.data(), packed.size(), voxels.data(),
                                    voxels.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

void require_sound_nrrd(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  NrrdPacking packing = packing_of(path, in, 1);
  if (!packing.is_gzip) return;
  const bool is_detached = !packing.files.empty();
  if (!is_detached) packing.files.push_back(path);
  for (const fs::path& file : packing.files) {
    std::ifstream lines(file, std::ios::binary);
    lines.seekg(is_detached ? 0 : packing.header_bytes);
    std::string skipped;
    for (int i = 0; i < packing.skipped_lines; ++i) std::getline(lines, skipped);
    if (!lines) continue;  // The library behind ITK says so better.
    GzipInput input(file, lines.tellg());
    require_sound_rest(input, file);
  }
}

}  // namespace lumesh::io
