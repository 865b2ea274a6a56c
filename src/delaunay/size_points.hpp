#pragma once
/// @file What is asked of points that sizes are taken from.

#include <span>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// @throws Error{kBadInput} unless there are points, all of them finite.
void require_size_points(std::span<const Vec3> points_mm);

}  // namespace lumesh
