#include "unit_and_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "lumesh/core/trimmed.hpp"

namespace lumesh::io {

namespace {

constexpr std::string_view kEnds(" \t\r\n;#\0", 7);  // Of words.

/// Text after "key=" at the beginning of a word, up to the next space, in lower case. Spaces may be before
/// it.
std::string value_of(const std::string& text, std::string_view key) {
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    if (at > 0 && kEnds.find(text[at - 1]) == std::string_view::npos) continue;
    const std::size_t begin = text.find_first_not_of(" \t", at + key.size());
    if (begin == std::string::npos) return "";
    return text.substr(begin, std::min(text.size(), text.find_first_of(kEnds, begin)) - begin);
  }
  return "";
}

}  // namespace

std::string unit_and_frame(const MeshInfo& info) {
  return fmt::format("lumesh SPACE={} UNIT={}", info.frame, info.unit);
}

void read_unit_and_frame(std::string_view comment, MeshInfo& info) {
  const std::string text = lower_case(std::string(comment));
  if (const std::string unit = value_of(text, "unit="); !unit.empty()) info.unit = unit;
  const std::string frame = value_of(text, "space=");
  if (frame == "lps") info.frame = "LPS";
  if (frame == "ras") info.frame = "RAS";
}

}  // namespace lumesh::io
