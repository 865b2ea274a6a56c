#pragma once
/// @file How large the surface of that is which is meshed.

#include "lumesh/image/label_image.hpp"

namespace lumesh::pipeline {

struct OutsideSize {
  double area_mm2 = 0, volume_mm3 = 0;
};

/// Area around all voxels that are not background. Faces at the border of the image, where openings will be,
/// are left out; of the others two thirds count, since squares between voxels have 1.5 times the area of a
/// smooth surface, on average over its directions. Parallel inside, bitwise identical for every thread count.
[[nodiscard]] OutsideSize outside_of(const LabelImage& image);

}  // namespace lumesh::pipeline
