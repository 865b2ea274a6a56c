#pragma once
/// @file The section of a vessel at an opening, carried along a direction.

#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// How far inside of an extended vessel, with some air around it, a place is. Known by squares of the
/// opening's plane, to which places go back along the direction.
struct CarriedSection {
  Vec3 centre_mm = Vec3::Zero();              ///< Centre of the section, on the plane.
  Vec3 normal = Vec3::UnitZ();                ///< Unit normal of the plane.
  Vec3 direction = Vec3::UnitZ();             ///< Unit, along the vessel; leads out of the plane.
  Vec3 first_mm = Vec3::Zero();               ///< Centre of the first square.
  Vec3 u = Vec3::UnitX(), v = Vec3::UnitY();  ///< Unit, along rows and columns.
  double step_mm = 1;
  int columns = 0, rows = 0;
  std::vector<float> inside;  ///< At the squares, mm.
  double circle_mm = -1e300;  ///< Radius of what the section becomes, with air; negative: it is kept.

  [[nodiscard]] Vec3 square(int column, int row) const { return first_mm + step_mm * (column * u + row * v); }
  /// The place of the plane that a point was carried from.
  [[nodiscard]] Vec3 carried_back(const Vec3& x) const {
    return x - (x - centre_mm).dot(normal) / direction.dot(normal) * direction;
  }
  [[nodiscard]] double off_axis_mm(const Vec3& x) const {
    const Vec3 off = x - centre_mm;
    return (off - off.dot(direction) * direction).norm();
  }
  /// Negative outside, by about the distance.
  [[nodiscard]] double inside_mm(const Vec3& x) const;
  /// The same of a place of the plane, without the circle.
  [[nodiscard]] double inside_section_mm(const Vec3& on_plane) const;
};

}  // namespace lumesh
