#pragma once
/// @file Where the boundary of a segmented object runs between voxels' centres, by the values it was made of.

#include <cstddef>
#include <cstdint>
#include <limits>

#include "lumesh/image/grey_values.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Faces between the background and the object.
struct CrossingCounts {
  std::size_t faces = 0;
  std::size_t crossed = 0;  ///< Of which the crossing is known now.
  std::size_t against = 0;  ///< Of which the values are not the object's inside, or are outside, too.
  /// Values beside the boundary are two, or up to sixteen whole numbers: they are labels and tell no places.
  bool values_are_labels = false;
};

/// Values of the object: from `low` to `high`, both included.
struct ObjectValues {
  double low, high;

  // Not explicit: a level alone is where the object begins.
  ObjectValues(double from, double to = std::numeric_limits<double>::infinity()) : low(from), high(to) {}
  [[nodiscard]] bool contain(double value) const { return value >= low && value <= high; }
};

/// How values run between the centres of two voxels.
enum class Interpolation : std::uint8_t {
  kLinear,     ///< As marching cubes have it; for what is blurred over a voxel or two.
  kQuadratic,  ///< With the lesser second difference of both ends, for distances (Min and Gibou 2007,
               ///< doi:10.1016/j.jcp.2006.11.034, section 2.3).
};

/// Sets the crossings of an image: where between two voxels' centres the values leave those of the object.
/// Faces whose values are against the labels, or infinite or NaN, get none.
/// @param values  One for each voxel, in their order.
/// Cost: one pass over the image. Threads: same result for every number of them.
CrossingCounts find_crossings(const VoxelValues& values, const ObjectValues& object, LabelImage& image,
                              Interpolation interpolation = Interpolation::kLinear);

/// The faces of an image and those of which it knows the crossing; the rest stays as it is. Cost: one pass.
[[nodiscard]] CrossingCounts count_crossings(const LabelImage& image);

}  // namespace lumesh
