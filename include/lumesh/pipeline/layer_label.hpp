#pragma once
/// @file The label of boundary layers as people write it.

#include <string>

#include "lumesh/layers/layers.hpp"

namespace lumesh {

/// Takes "wall=2", "wall" or "2" into the options; an empty text says nothing.
/// @throws Error{kBadInput}, which does not name the option.
void take_layer_label(const std::string& text, LayerOptions& options);

}  // namespace lumesh
