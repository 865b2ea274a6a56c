#pragma once
/// @file Which part a cut through one vessel removes.

#include <cstdint>

namespace lumesh {

/// The smaller part, or that on the normal's side of the plane.
enum class CutPart : std::uint8_t { kSmaller, kAbove };

}  // namespace lumesh
