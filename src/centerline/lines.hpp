#pragma once
/// @file From paths through voxels to lines.

#include <vector>

#include "tube.hpp"
#include "voxel_tree.hpp"

namespace lumesh::centerline {

/// Distance between the points of a line where none is given, in radii.
inline constexpr double kUsualSpacing = 0.25;

/// A tube for each path, in its order; where a path joins another one its tube ends at a point of that one's.
/// @param spacing_mm  As in CenterlineOptions.
[[nodiscard]] std::vector<Tube> tubes_along(const Lumen& lumen, const std::vector<VoxelPath>& paths,
                                            double spacing_mm);

}  // namespace lumesh::centerline
