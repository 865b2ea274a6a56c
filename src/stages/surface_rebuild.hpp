#pragma once
// A surface made anew of what is inside of one with faults.

#include <string>

#include "lumesh/surface/distance.hpp"

namespace lumesh {

struct RebuiltSurface {
  TriangleMesh surface;
  surfaces::FarthestPoint moved;
  double spacing_mm = 0;
  std::string failure;  ///< Empty where it was made within the distance.
  Vec3 failure_mm = Vec3::Zero();
};

/// Inside is where the given surface winds around a point more than half; its boundary is contoured
/// (surfaces::contour_of_inside()) on a grid so fine that it lies within the distance. Parts of the given
/// surface that lie inside, such as those of tubes that cross, do not count for the distance.
/// @param given  Turned alike and outwards, without openings.
[[nodiscard]] RebuiltSurface rebuild_surface(const TriangleMesh& given, double max_distance_mm);

}  // namespace lumesh
