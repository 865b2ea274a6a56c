#pragma once
// Images that are no segmentations, told by few of their voxels.

#include "lumesh/image/label_image.hpp"

namespace lumesh::field {

/// Looks at every n-th slice so that there are about 32. Refused are images in which more than 100,000 pairs
/// of labels touch, and those in which more than a quarter of the object's voxels touch no other of their
/// label, if these voxels times the pairs of labels (and four) are more than a million, or if nine in ten and
/// more than 10,000 do: functions of single voxels take minutes then, and mean nothing.
/// @throws Error{kBadInput}, in one line with the remedy. Cost: a look at 32 slices, whatever they hold.
void require_segmentation(const LabelImage& image);

/// @throws Error{kBadInput} if more than 100,000 pairs of labels touch.
void require_few_pairs(std::size_t pairs);

}  // namespace lumesh::field
