#pragma once
/// @file Numbers of things in messages.

#include <fmt/core.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace lumesh {

/// "1 face has", "2 faces have".
[[nodiscard]] inline std::string counted(std::uint64_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}
/// "1 piece", "2 pieces".
[[nodiscard]] inline std::string counted(std::uint64_t count, std::string_view one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

}  // namespace lumesh
