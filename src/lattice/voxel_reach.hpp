#pragma once
// Keeps the boundary within reach of the voxels that it bounds.

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Moves a point between the materials of a set towards the nearest boundary voxel of each of its labels
/// until its centre is at most 1.12 half diagonals of a voxel away (0.97 voxels for cubic ones). On a flat
/// boundary along the grid no point is further than one half diagonal, so this only trims bulges of the
/// smoothed boundary.
[[nodiscard]] Vec3 within_reach_of_voxels(const LabelImage& image, const ImageDomain& domain,
                                          const MaterialSet& materials, const Vec3& point_mm);

/// How far a point between the materials of a set is from the nearest centre of a boundary voxel of that of
/// its labels where this is most, in mm; two voxels more than `enough_mm` where none is near. Exact only
/// above `enough_mm`.
[[nodiscard]] double distance_to_voxels_mm(const LabelImage& image, const ImageDomain& domain,
                                           const MaterialSet& materials, const Vec3& point_mm,
                                           double enough_mm);

}  // namespace lumesh
