#pragma once
// Means over the next voxels.

#include "band.hpp"
#include "lanes.hpp"

namespace lumesh::field {

/// Replaces values (NaN outside the band) by their means with weights 1 2 1 along each axis. Where a voxel
/// has no neighbour on one side, values stay along that axis: linear functions stay everywhere.
void binomial_mean(const Band& band, LaneArray& values, LaneArray& scratch);

}  // namespace lumesh::field
