#pragma once
/// @file Numbers from texts.

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace lumesh {

/// The whole text as a number; none if it is anything else.
template <class Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, number);
  return fault == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

}  // namespace lumesh
