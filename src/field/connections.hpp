#pragma once
// The topology between voxels' centres.

#include <vector>

#include "band.hpp"
#include "lanes.hpp"

namespace lumesh::field {

/// Raises values of the function just so far that it has the side of voxels that lie in one edge, square or
/// cube of the grid in the middle of these, too, where cubic interpolation would leave it: thin parts would
/// come apart between their voxels.
/// @param near  A bit for each lane where this may be needed.
void keep_connections(const Band& band, const std::vector<std::uint8_t>& near, LaneArray& values);

}  // namespace lumesh::field
