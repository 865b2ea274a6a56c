#pragma once
/// @file What surrounds a voxel.

#include "lumesh/core/grid.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// How many of the 27 voxels around (the voxel itself included) have its label. About 14 on a flat boundary,
/// fewer at tips and edges: a measure of how much the voxel sticks out. `label_at(i, j, k)` gives the labels,
/// counted from the voxel.
template <class LabelAt>
[[nodiscard]] int same_label_count(const LabelAt& label_at) {
  const LabelImage::Index own = label_at(0, 0, 0);
  int count = 0;
  for_each_place(Index3::Constant(-1), Index3::Ones(),
                 [&](const Index3& step) { count += label_at(step.x(), step.y(), step.z()) == own ? 1 : 0; });
  return count;
}

/// The same for a voxel of an image; outside it the border voxels go on.
[[nodiscard]] inline int same_label_count(const LabelImage& image, const Index3& voxel) {
  return same_label_count([&](int i, int j, int k) { return image.at_nearest(voxel + Index3(i, j, k)); });
}

}  // namespace lumesh
