#pragma once
/// @file Texts without what stands around them, and in small letters.

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace lumesh {

/// @param around  Characters that count as blank. @return A part of the text.
[[nodiscard]] constexpr std::string_view trimmed(std::string_view text, std::string_view around = " \t") {
  const std::size_t begin = text.find_first_not_of(around);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(around) + 1 - begin);
}

/// The text in small letters; those beyond ASCII stay as they are.
[[nodiscard]] inline std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace lumesh
