#pragma once
/// @file Coverage by the columns of layers, patch by patch.

#include "columns.hpp"

namespace lumesh::layers {

/// One entry for each patch with layers.
[[nodiscard]] std::vector<LayerCoverage> coverage_of(const TetMesh& mesh, const ExtrusionFrame& frame,
                                                     const Columns& columns);

/// The shares that the columns achieved. @param is_inward  The surface's triangles are seen from within.
[[nodiscard]] LayerShares shares_on(const LayerSurface& surface, const Columns& columns, bool is_inward);

}  // namespace lumesh::layers
