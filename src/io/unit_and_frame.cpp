#include "unit_and_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "lumesh/core/trimmed.hpp"
#include "lumesh/mesh/length_unit.hpp"

namespace lumesh::io {

namespace {

constexpr std::string_view kBlank = " \t", kEnds(" \t\r\n;#,\"'=:\0", 12);  // Of words.

bool is_begin(const std::string& text, std::size_t at) {
  return at == 0 || kEnds.find(text[at - 1]) != std::string_view::npos;
}

/// The word of letters after "key=", "key = " or "key: ", of text in lower case; empty where none follows.
std::string word_after(const std::string& text, std::string_view key) {
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const std::size_t sign = text.find_first_not_of(kBlank, at + key.size());
    if (!is_begin(text, at) || sign == std::string::npos || (text[sign] != '=' && text[sign] != ':'))
      continue;
    const std::size_t begin = text.find_first_not_of(" \t\"'", sign + 1);
    if (begin == std::string::npos) return "";
    const std::size_t end = std::min(text.size(), text.find_first_of(kEnds, begin));
    const std::size_t after = text.find_first_not_of(kBlank, end);
    const bool is_next_key = after != std::string::npos && text[after] == '=';
    const bool has_letters = std::any_of(text.begin() + static_cast<std::ptrdiff_t>(begin),
                                         text.begin() + static_cast<std::ptrdiff_t>(end),
                                         [](char c) { return c < 0 || (c >= 'a' && c <= 'z'); });
    return is_next_key || !has_letters ? "" : text.substr(begin, end - begin);
  }
  return "";
}

/// One letter for each axis, such as "las".
bool is_frame(std::string_view word) {
  constexpr std::array<std::string_view, 3> kSides = {"lr", "ap", "is"};
  return word.size() == kSides.size() && std::ranges::all_of(kSides, [&](std::string_view sides) {
           return std::ranges::any_of(word, [&](char c) { return sides.find(c) != std::string_view::npos; });
         });
}

std::string upper_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return static_cast<char>(c - 'a' + 'A'); });
  return text;
}

}  // namespace

std::string unit_and_frame(const MeshInfo& info) {
  return fmt::format("lumesh SPACE={} UNIT={}", info.frame, info.unit);
}

void read_unit_and_frame(std::string_view comment, MeshInfo& info) {
  const std::string text = lower_case(std::string(comment));
  for (const char* key : {"units", "unit"})
    if (const std::string unit = word_after(text, key); !unit.empty()) info.unit = unit_called(unit);
  const std::string frame = word_after(text, "space");
  if (is_frame(frame)) info.frame = upper_case(frame);
}

}  // namespace lumesh::io
