#include "unit_and_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "lumesh/mesh/length_unit.hpp"

namespace lumesh::io {

namespace {

/// Text after "key=" at the beginning of a word, up to the next space.
std::string_view value_of(std::string_view text, std::string_view key) {
  constexpr std::string_view kEnds(" \t\r\n;\0", 6);
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    if (at > 0 && kEnds.find(text[at - 1]) == std::string_view::npos) continue;
    const std::string_view rest = text.substr(at + key.size());
    return rest.substr(0, std::min(rest.size(), rest.find_first_of(kEnds)));
  }
  return {};
}

}  // namespace

std::string unit_and_frame(const MeshInfo& info) {
  return fmt::format("lumesh SPACE={} UNIT={}", info.frame, info.unit);
}

void read_unit_and_frame(std::string_view comment, MeshInfo& info) {
  if (const std::string_view unit = value_of(comment, "UNIT="); unit_in_mm(unit) > 0) info.unit = unit;
  if (const std::string_view frame = value_of(comment, "SPACE="); frame == "LPS" || frame == "RAS")
    info.frame = frame;
}

}  // namespace lumesh::io
