#pragma once
/// @file Whether lengths of a file can be millimetres.

#include <string>

namespace lumesh {

/// What to say of an image or a surface that is so long; empty if vessels are: between a few mm and a body's
/// length, and unless the whole is long and its widest opening as thin as large vessels are in cm.
/// @param widest_radius_mm  Of the openings; 0: not known.
[[nodiscard]] std::string unit_doubt(double longest_mm, double widest_radius_mm = 0);

}  // namespace lumesh
