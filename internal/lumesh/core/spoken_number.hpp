#pragma once
/// @file Numbers in the texts of options: what a text says of a default is made from the constant itself.

#include <fmt/core.h>

#include <array>
#include <string>
#include <utility>

namespace lumesh {

/// Number as a text says it: "a quarter" of something, "four million", else its digits, "2.5", "2e-6".
[[nodiscard]] inline std::string spoken(double number) {
  constexpr std::array<std::pair<double, const char*>, 5> kWords = {
      {{0.5, "half"}, {0.25, "a quarter"}, {0.125, "an eighth"}, {0.1, "a tenth"}, {4e6, "four million"}}};
  for (const auto& [value, words] : kWords)
    if (number == value) return words;
  std::string digits = fmt::format("{:g}", number);
  if (const std::size_t exponent = digits.find("e-0"); exponent != std::string::npos)
    digits.erase(exponent + 2, 1);
  return digits;
}

}  // namespace lumesh
