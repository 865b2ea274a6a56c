#pragma once
/// @file Openings at the image's border against the voxels there.

#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// A line for each opening at the border whose section is far from what the faces of the border's voxels say:
/// its area by more than a tenth and 0.7 voxels times the section's width, or joined from separate sections;
/// and for sections of at least 8 faces that are in no opening. Smooth sections and voxels differ by less,
/// measured on oblique cylinders of 1.5 to 20 voxels in radius.
/// @param cuts  What lies beyond them is left out. Cost: linear in the faces of the border.
[[nodiscard]] std::vector<std::string> doubts_about_sections(const LabelImage& image,
                                                             std::span<const CutPlane> cuts,
                                                             std::span<const Opening> openings);

}  // namespace lumesh
