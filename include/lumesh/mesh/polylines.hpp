#pragma once
/// @file Curves with data on their points: centerlines and streamlines.

#include <cstdint>
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

/// Length of one line of them.
[[nodiscard]] inline double length_mm(const Polylines& lines, const std::vector<std::uint32_t>& line) {
  double length_mm = 0;
  for (std::size_t i = 1; i < line.size(); ++i)
    length_mm += (lines.points[line[i]] - lines.points[line[i - 1]]).norm();
  return length_mm;
}

/// Length of all lines together.
[[nodiscard]] inline double length_mm(const Polylines& lines) {
  double sum_mm = 0;
  for (const std::vector<std::uint32_t>& line : lines.lines) sum_mm += length_mm(lines, line);
  return sum_mm;
}

}  // namespace lumesh
