#pragma once
/// @file Lines as round tubes on the screen.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "camera.hpp"
#include "raster.hpp"

namespace lumesh::report {

/// Adds a tube along a line with balls at its ends, shaded and without outlines.
/// @param radius_pixels  The same from end to end.
/// @param colour_of      Of a point; each piece between two points has the colour of the first.
void add_tube(const Camera& camera, std::span<const Vec3> points, std::span<const std::uint32_t> line,
              double radius_pixels, const std::function<Colour(std::uint32_t)>& colour_of,
              std::vector<ScreenTriangle>& out);

}  // namespace lumesh::report
