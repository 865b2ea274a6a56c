#pragma once
/// @file Exact Euclidean distance of voxels to the nearest voxel of another label.

#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Distances in a box of voxels; i runs fastest.
struct DistanceField {
  Index3 low = Index3::Zero();   ///< First voxel of the box.
  Index3 size = Index3::Zero();  ///< Voxels along i, j, k.
  std::vector<float> distance_mm;

  /// Distance at a voxel of the image that lies in the box.
  [[nodiscard]] float at(const Index3& voxel) const { return distance_mm[grid_offset(size, voxel - low)]; }
};

/// Distance from every voxel centre in [low, high) to the nearest voxel centre of the box that has another
/// label (the background is a label like any other), but at most `max_distance_mm`. Voxels outside the box
/// are not looked at: make the box larger by `max_distance_mm` than the part of interest.
///
/// @throws Error{kBadInput} if the box is empty or leaves the image, or the distance is not positive and
/// finite. Threads: parallel over slices and columns; bitwise identical for every thread count. Cost: linear
/// in the box, with a factor of at most 2 max_distance / spacing near label changes and next to nothing
/// elsewhere. Memory: 4 bytes a voxel. Method: separable squared distance with one parabola window per column
/// (Saito and Toriwaki 1994, doi:10.1016/0031-3203(94)90133-3), on many columns at once; a voxel of another
/// label counts as distance zero, which gives all labels in one pass.
[[nodiscard]] DistanceField distance_to_label_change(const LabelImage& image, const Index3& low,
                                                     const Index3& high, double max_distance_mm);

}  // namespace lumesh
