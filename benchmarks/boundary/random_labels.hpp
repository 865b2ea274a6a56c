#pragma once
/// @file Random label images, as awkward as real ones can be.

#include <cstdint>
#include <string>

#include "lumesh/image/label_image.hpp"

namespace lumesh::boundary {

struct RandomLabels {
  std::string kind;  ///< "blobs", "tubes", "checkerboard", "sheets", "border", "regions" or "mixture".
  LabelImage image;
};

/// 24 to 48 voxels along each axis, 1 to 20 labels; the kinds take turns. One image in five has voxels of
/// 1:1:1.5 mm, the others of 1 mm. Labels that got no voxel are not among values().
[[nodiscard]] RandomLabels random_labels(std::uint64_t seed);

}  // namespace lumesh::boundary
