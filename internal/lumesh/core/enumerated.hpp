#pragma once
/// @file Lists of words in messages.

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

namespace lumesh {

/// At most so many of the words: "a, b, c", "a, b and 5 more".
[[nodiscard]] inline std::string enumerated(std::span<const std::string> words, std::size_t max) {
  std::string text;
  for (const std::string& word : words.first(std::min(max, words.size())))
    text += (text.empty() ? "" : ", ") + word;
  if (words.size() > max) text += fmt::format(" and {} more", words.size() - max);
  return text;
}

}  // namespace lumesh
