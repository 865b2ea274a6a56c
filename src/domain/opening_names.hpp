#pragma once
// Names of openings, and which of them are rims of walls.

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/patch_names.hpp"

namespace lumesh {

/// Sets is_rim of the openings of one cut plane.
void mark_rims(std::span<Opening> openings);

[[nodiscard]] inline bool has_label(std::span<const Opening> openings, Label label) {
  return std::any_of(openings.begin(), openings.end(), [&](const Opening& o) { return o.label == label; });
}

/// Sets the names of all openings, in their order.
void name_openings(const PatchNaming& naming, std::span<Opening> openings);

}  // namespace lumesh
