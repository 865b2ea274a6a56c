#pragma once
/// @file What the columns of layers achieved, patch by patch.

#include "columns.hpp"

namespace lumesh::layers {

/// One entry for each patch with layers.
[[nodiscard]] std::vector<LayerCoverage> coverage_of(const TetMesh& mesh, const LayerSurface& surface,
                                                     const Columns& columns);

}  // namespace lumesh::layers
