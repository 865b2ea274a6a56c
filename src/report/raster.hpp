#pragma once
/// @file Drawing of flat-shaded triangles with a depth buffer.

#include <array>
#include <cstdint>
#include <vector>

#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// A triangle on the screen, in pixels: x right, y down, z towards the viewer.
struct ScreenTriangle {
  std::array<std::array<float, 3>, 3> corners;  ///< x, y, z each.
  std::array<float, 3> normal;                  ///< Unit, in screen axes with y up; z > 0 faces the viewer.
  Colour colour;
  std::uint8_t outlined = 0;  ///< Bit i: draw the side from corner i to corner i + 1.
  bool matt = false;          ///< True: shown in its own colour, without shading (cut faces).
};

/// Draws with shading, outlines and ambient occlusion. Threads: parallel over rows, same pixels for every
/// thread count.
[[nodiscard]] Picture rasterise(const std::vector<ScreenTriangle>& triangles, int width, int height,
                                int supersampling);

}  // namespace lumesh::report
