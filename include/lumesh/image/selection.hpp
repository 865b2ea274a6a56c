#pragma once
/// @file Choosing labels of an image.

#include <span>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Keeps the named labels; all others become background and leave image.values().
/// @throws Error{kBadInput} if a label has no voxel (the message lists those that have), is 0, or none is
/// named. Threads: parallel over the voxels, same result for every number of threads. Cost: two scans of the
/// image.
void select_labels(LabelImage& image, std::span<const Label> labels);

}  // namespace lumesh
