#pragma once
// The smooth function whose zero set is the boundary between two labels.

#include "band.hpp"
#include "lanes.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh::field {

/// The function of least third derivatives within the sides that the voxels say, in edges of the smallest
/// voxel edge: slope about 1 at the boundary, NaN outside the band. Source: docs/stages/domain.md.
/// @param faces  Those of the band.
[[nodiscard]] LaneArray fit(const Band& band, const PairFaces& faces, BoundaryFidelity fidelity);

}  // namespace lumesh::field
