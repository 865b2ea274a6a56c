#pragma once
/// @file Places in messages.

#include <fmt/core.h>

#include <string>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// "(12.5, -40, 8)", with so many significant digits.
[[nodiscard]] inline std::string coordinates_text(const Vec3& p, int digits = 6) {
  return fmt::format("({0:.{3}g}, {1:.{3}g}, {2:.{3}g})", p.x(), p.y(), p.z(), digits);
}
/// "(12.5, -40.0, 8.0)", with so many decimals.
[[nodiscard]] inline std::string decimals_text(const Vec3& p, int decimals) {
  return fmt::format("({0:.{3}f}, {1:.{3}f}, {2:.{3}f})", p.x(), p.y(), p.z(), decimals);
}
/// "(12.5, -40.0, 8.0) mm".
[[nodiscard]] inline std::string place_text(const Vec3& p) {
  return decimals_text(p, 1) + " mm";
}

}  // namespace lumesh
