#pragma once
/// @file The part of the stage `check` that looks at images.

#include "lumesh/image/label_image.hpp"
#include "lumesh/stages/check_stage.hpp"

namespace lumesh {

[[nodiscard]] CheckReport check_image(const LabelImage& image);

}  // namespace lumesh
