#pragma once
/// @file What surrounds a voxel.

#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// How many of the 27 voxels around (the voxel itself included) have its label; outside the image the border
/// voxels go on. About 14 on a flat boundary, fewer at tips and edges: a measure of how much the voxel sticks
/// out.
[[nodiscard]] inline int same_label_count(const LabelImage& image, const Index3& voxel) {
  const Index3 last = image.frame().size - Index3::Ones();
  const LabelImage::Index own = image.at(voxel);
  int count = 0;
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        const Index3 other = (voxel + Index3(i, j, k)).cwiseMax(0).cwiseMin(last);
        count += image.at(other) == own ? 1 : 0;
      }
    }
  }
  return count;
}

}  // namespace lumesh
