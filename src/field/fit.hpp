#pragma once
// The smooth function whose zero set is the boundary between two labels.

#include "band.hpp"
#include "lanes.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh::field {

struct PairFunction {
  LaneArray
      values;  ///< In edges of the smallest voxel edge, slope about 1 at the boundary; NaN outside the band.
  int iterations = 0;
};

/// Least third derivatives within the sides that the voxels say. Source: docs/stages/domain.md.
[[nodiscard]] PairFunction fit(const Band& band, BoundaryFidelity fidelity);

}  // namespace lumesh::field
