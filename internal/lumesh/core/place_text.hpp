#pragma once
/// @file Places in messages.

#include <fmt/core.h>

#include <string>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// "(12.5, -40.0, 8.0) mm".
inline std::string place_text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", p.x(), p.y(), p.z());
}

}  // namespace lumesh
