#pragma once
/// @file Curves with data on their points: centerlines and streamlines.

#include <map>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Points shared by any number of open polylines, with named arrays, one value per point.
struct Polylines {
  std::vector<Vec3> points;                            ///< mm.
  std::vector<std::vector<std::uint32_t>> lines;       ///< Point indices in order.
  std::map<std::string, std::vector<double>> scalars;  ///< Such as "radius" (mm).
  std::map<std::string, std::vector<Vec3>> vectors;    ///< Such as "velocity" (m/s).
};

}  // namespace lumesh
