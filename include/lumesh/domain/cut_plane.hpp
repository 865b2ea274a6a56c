#pragma once
/// @file Planes that cut the object off, and what they leave of an image.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// A plane that cuts the object off: what lies on the side of the normal is removed.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Need not be of unit length, must not be zero.
};

/// Voxels of each label (in the order of image.values(), 0 for the background) on the kept side of all
/// planes. Voxels that a plane passes through count by their share, taken as linear in the plane's place.
[[nodiscard]] std::vector<double> count_kept_voxels(const LabelImage& image,
                                                    std::span<const CutPlane> planes);

}  // namespace lumesh
