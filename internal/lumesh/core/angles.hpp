#pragma once
/// @file Angles in degrees, as users and messages have them, and in radians.

#include <cmath>
#include <numbers>

namespace lumesh {

[[nodiscard]] constexpr double radians(double angle_deg) {
  return angle_deg * std::numbers::pi / 180;
}
[[nodiscard]] constexpr double degrees(double angle_rad) {
  return angle_rad * 180 / std::numbers::pi;
}
/// Cosine of an angle in degrees.
[[nodiscard]] inline double cosine_deg(double angle_deg) {
  return std::cos(radians(angle_deg));
}

}  // namespace lumesh
