// The voxels of the NRRD files that most programs write, http://teem.sourceforge.net/nrrd/format.html.
#include <libdeflate.h>

#include <bit>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/trimmed.hpp"
#include "raw_image.hpp"

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

bool holds(std::string_view line, std::string_view word) {
  return line.find(word) != std::string_view::npos;
}

/// A comment, a note "key:=value" or what the image is of.
bool is_free_text(std::string_view line) {
  const std::size_t colon = line.find(':');
  return line.starts_with('#') || line.starts_with("content:") ||
         (colon != std::string_view::npos && line.substr(colon).starts_with(":="));
}

/// Unit named by a line such as: space units: "m" "m" "m".
double unit_mm(std::string_view line) {
  const std::size_t begin = line.find('"'), end = line.find('"', begin + 1);
  if (begin == std::string_view::npos || end == std::string_view::npos) return 1;
  const std::string_view unit = line.substr(begin + 1, end - begin - 1);
  if (unit == "m" || unit == "meter" || unit == "meters") return 1000;
  if (unit == "cm") return 10;
  if (unit == "um" || unit == "micron" || unit == "microns" || unit == "micrometer") return 0.001;
  return 1;
}

/// Whether a text stands for names of files by their numbers, such as "slice%03d.raw".
bool is_pattern(std::string_view text) {
  std::size_t at = text.find('%');
  if (at == std::string_view::npos) return false;
  at = text.find_first_not_of("0123456789", at + 1);
  return at != std::string_view::npos && text[at] == 'd';
}

/// Reads the header; true if it says that one gzip stream in this machine's byte order follows.
bool gzip_follows(std::istream& in, std::size_t voxel_bytes) {
  bool packed = false;
  bool own_order = voxel_bytes == 1;
  std::string text;
  for (bool first = true; std::getline(in, text); first = false) {
    text = lower_case(std::move(text));
    std::string_view line = text;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) return packed && own_order;
    if (first && !line.starts_with("nrrd")) return false;
    if (is_field(line, "datafile") || is_field(line, "lineskip") || is_field(line, "byteskip")) return false;
    if (is_field(line, "encoding")) packed = holds(line, "gz");
    if (is_field(line, "endian"))
      own_order |= holds(line, std::endian::native == std::endian::little ? "little" : "big");
  }
  return false;
}

}  // namespace

NrrdNotes nrrd_notes(const fs::path& path) {
  constexpr std::size_t kLongestText = 8000, kLongestField = 500;  // Teem's messages quote fields.
  std::ifstream in(path, std::ios::binary);
  NrrdNotes notes;
  std::string text;
  while (std::getline(in, text) && !text.empty() && text != "\r") {
    if (text.size() > (is_free_text(text) ? kLongestText : kLongestField))
      fail(path, "has a damaged header (a very long line); save it again");
    text = lower_case(std::move(text));
    const bool has_digits = text.find_first_of("0123456789") != std::string::npos;
    if (is_field(text, "spacings") || is_field(text, "spacedirections"))
      notes.has_spacing = notes.has_spacing || has_digits;
    if (is_field(text, "spaceunits")) notes.unit_mm = unit_mm(text);
    if (is_field(text, "datafile") && is_pattern(text))
      fail(path, "keeps its voxels in files named by a pattern; save it as one .nrrd file");
  }
  return notes;
}

bool unpack_nrrd(const fs::path& path, std::size_t voxel_bytes, std::span<std::byte> voxels) {
  std::ifstream in(path, std::ios::binary);
  if (!gzip_follows(in, voxel_bytes)) return false;
  const std::vector<char> packed((std::istreambuf_iterator<char>(in)), {});
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!inflater) return false;
  const libdeflate_result result = libdeflate_gzip_decompress(inflater.get(), packed.data(), packed.size(),
                                                              voxels.data(), voxels.size(), nullptr);
  // Or its checksum is wrong, which ITK would not see.
  if (result == LIBDEFLATE_BAD_DATA)
    fail(path, "is damaged: its compressed voxels are not what was written; copy it again");
  return result == LIBDEFLATE_SUCCESS;
}

}  // namespace lumesh::io
