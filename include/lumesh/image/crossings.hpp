#pragma once
/// @file Where the boundary of a segmented object runs between voxels' centres, by the values it was made of.

#include <cstddef>
#include <span>

#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Faces between the background and the object.
struct CrossingCounts {
  std::size_t faces = 0;
  std::size_t crossed = 0;  ///< Of which the crossing is known now.
  std::size_t against =
      0;  ///< Of which the values are not below the level outside and at or above it inside.
  /// Values beside the boundary are two, or up to sixteen whole numbers: they are labels and tell no places.
  bool values_are_labels = false;
};

/// Sets the crossings of an image: where the line through the values at two voxels' centres reaches `level`,
/// as marching cubes have it. Faces whose values are against the labels, or infinite or NaN, get none.
/// @param values  One for each voxel, in their order; greater inside of the object than outside.
/// Cost: one pass over the image. Threads: same result for every number of them.
template <class Value>
CrossingCounts find_crossings(std::span<const Value> values, double level, LabelImage& image);

/// The faces of an image and those of which it knows the crossing; the rest stays as it is. Cost: one pass.
[[nodiscard]] CrossingCounts count_crossings(const LabelImage& image);

}  // namespace lumesh
