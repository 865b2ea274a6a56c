// The voxels of the NRRD files that most programs write, http://teem.sourceforge.net/nrrd/format.html.
#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

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

/// Reads the header; true if it says that one gzip stream in this machine's byte order follows.
bool gzip_follows(std::istream& in, std::size_t voxel_bytes) {
  bool packed = false;
  bool own_order = voxel_bytes == 1;
  std::string text;
  for (bool first = true; std::getline(in, text); first = false) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
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

bool nrrd_has_spacing(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text;
  while (std::getline(in, text)) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    if (text.empty() || text == "\r") return false;
    if (is_field(text, "spacings") || is_field(text, "spacedirections"))
      return text.find_first_of("0123456789") != std::string::npos;
  }
  return false;
}

bool unpack_nrrd(const fs::path& path, std::size_t voxel_bytes, std::span<std::byte> voxels) {
  std::ifstream in(path, std::ios::binary);
  if (!gzip_follows(in, voxel_bytes)) return false;
  const std::vector<char> packed((std::istreambuf_iterator<char>(in)), {});
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  return inflater && libdeflate_gzip_decompress(inflater.get(), packed.data(), packed.size(), voxels.data(),
                                                voxels.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

}  // namespace lumesh::io
