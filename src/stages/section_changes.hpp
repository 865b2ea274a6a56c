#pragma once
// Openings at the border whose section is uncertain, as the vessel bends there.

#include <optional>

#include "lumesh/domain/openings.hpp"

namespace lumesh {

/// The share by which the area of an opening at the image's border exceeds the section's one voxel further
/// in, less what the section changes by from there on; none within 4 %, and for openings of more than 6
/// voxels in radius. Nothing beyond the border holds the boundary there. Sections of straight vessels change
/// by 0.5 % (s.d.; 1.4 % from 2 voxels in radius on, 35 degrees oblique), those of bent ones by about three
/// quarters of what the area is off by.
[[nodiscard]] std::optional<double> doubtful_change(const Domain& domain, const Opening& opening);

}  // namespace lumesh
