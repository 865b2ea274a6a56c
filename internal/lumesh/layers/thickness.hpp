#pragma once
/// @file Thickness of layers against what they grow on.

#include <string_view>

namespace lumesh {

/// Layers thicker than all that they grow on are a slip, mostly of units.
/// @param thinnest_mm  Thickness of all layers where they are thinnest. @param thickness  As asked for.
/// @param on  "surface", for the message. @param width_mm  Diagonal of the box around that.
/// @throws Error{kBadInput} if they are.
void require_fitting_thickness(double thinnest_mm, double thickness, std::string_view on, double width_mm);

}  // namespace lumesh
