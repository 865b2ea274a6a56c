#pragma once
/// @file Names of openings that stay the same through the frames of an image.

#include <string>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"

namespace lumesh {

/// Gives the openings of a frame the names that openings of the frames before have at their places: of those
/// of the same label and of like normal the nearest, at most both radii away. Others get numbers that are
/// free.
/// @param known  Openings of the frames before, none before the first; those that are new are added.
/// @return Lines on openings that are new, and on known ones that the frame does not have. Cost: as
/// find_openings().
[[nodiscard]] std::vector<std::string> keep_opening_names(std::vector<Opening>& known, ImageDomain& domain);

}  // namespace lumesh
