#pragma once
/// @file Voxels that get another label.

#include <vector>

#include "lumesh/image/touching.hpp"

namespace lumesh::image {

/// Voxels of the background that does not reach the outside of all labels, joined through corners, by piece.
[[nodiscard]] std::vector<std::vector<Index3>> enclosed_pieces(const LabelImage& image);

/// The label that most of the voxels within two of one have; of equals the lowest. Background if none has
/// one.
/// @param voxels  Those of the image before it is changed.
[[nodiscard]] LabelImage::Index label_around(const LabelImage& image,
                                             const std::vector<LabelImage::Index>& voxels,
                                             const Index3& place);

/// Makes background of the component of all labels that a voxel belongs to.
void drop_component(const Index3& first, LabelImage& image, VoxelsChanged& changed);

/// Counts a voxel that has changed.
void note_change(const LabelImage& image, const Index3& place, VoxelsChanged& changed);

}  // namespace lumesh::image
