#pragma once
/// @file Hollows inside the voxels of a label.

#include "lumesh/image/runs.hpp"
#include "lumesh/image/topology.hpp"

namespace lumesh::image {

/// Pieces of what is not the label, joined through faces, edges or corners, that do not reach the outside;
/// beyond the image is outside. Cost: linear in the rows of the box and the runs in them.
/// @param box  That of the label's voxels.
[[nodiscard]] std::size_t count_cavities(const RunImage& runs, LabelImage::Index label, const VoxelBox& box);

}  // namespace lumesh::image
