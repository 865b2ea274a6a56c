#pragma once
// A surface made anew of what is inside of one with faults.

#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/surface/distance.hpp"

namespace lumesh {

struct RebuiltSurface {
  TriangleMesh surface;
  surfaces::FarthestPoint moved;
  double spacing_mm = 0;
  std::string failure;  ///< Empty where it was made within the distance.
  Vec3 failure_mm = Vec3::Zero();
};

/// Inside is where the given surface winds around a point (WindingNumbers above 1/2), on a grid so fine that
/// what is made lies within the distance; the grid with signed distances is meshed as an image is. Parts of
/// the given surface that lie inside, such as those of tubes that cross, do not count for the distance. New
/// triangles take the patch of the nearest given one.
/// @param given  Turned alike and outwards, without openings.
[[nodiscard]] RebuiltSurface rebuild_surface(const TriangleMesh& given, double max_distance_mm,
                                             Context& context);

}  // namespace lumesh
