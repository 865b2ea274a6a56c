#pragma once
/// @file Ways that begin and end level.

#include <algorithm>

namespace lumesh {

/// Rises from 0 to 1 over a length, level at both ends; 1 where there is no length.
[[nodiscard]] inline double smoothstep(double along, double length) {
  const double t = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 1;
  return t * t * (3 - 2 * t);
}

}  // namespace lumesh
