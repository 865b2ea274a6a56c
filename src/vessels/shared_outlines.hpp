#pragma once
// Openings of several labels that lie in or around one another.

#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/openings.hpp"

namespace lumesh {

/// Whether the planes of two openings are one but for half a voxel and the normals' rounding.
[[nodiscard]] bool are_nearly_coplanar(const Opening& a, const Opening& b);

/// A line for each pair of labels of which an opening shares more than a third of its outline with one of the
/// other label in its plane, as a lumen does with a thrombus around it or beside it; none where one of them
/// is the rim of a wall, as that is known. Vessels that touch side by side share a fifth. Cost:
/// linear in the squares of openings of several labels.
[[nodiscard]] std::vector<std::string> doubts_about_shared_outlines(std::span<const Opening> openings);

}  // namespace lumesh
