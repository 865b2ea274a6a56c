#pragma once
/// @file Whether lengths of a file can be millimetres.

#include <string>

namespace lumesh {

/// What to say of an image or a surface that is so long; empty if vessels are: between a few mm and a body's
/// length.
[[nodiscard]] std::string unit_doubt(double longest_mm);

}  // namespace lumesh
