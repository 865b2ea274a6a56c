#pragma once
/// @file Open surfaces that tests begin with.

#include <cmath>
#include <functional>
#include <numbers>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

struct TubeShape {
  double radius_mm = 3, length_mm = 20;
  int around = 48;
  /// Of the end at z = length: how much farther the surface goes there, by the angle.
  std::function<double(double angle)> end_height_mm = [](double) { return 0.0; };
  std::function<double(double z)> radius_factor = [](double) { return 1.0; };
};

/// Around the z axis from z = 0 on, open at both ends, triangles outwards and about as long as wide.
inline TriangleMesh open_tube(const TubeShape& shape) {
  const double step_mm = 2 * std::numbers::pi * shape.radius_mm / shape.around;
  const auto rows = static_cast<std::uint32_t>(std::max(2.0, std::round(shape.length_mm / step_mm)));
  const auto around = static_cast<std::uint32_t>(shape.around);
  TriangleMesh tube;
  for (std::uint32_t row = 0; row <= rows; ++row)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around, share = static_cast<double>(row) / rows;
      const double z = share * (shape.length_mm + shape.end_height_mm(angle));
      const double r = shape.radius_mm * shape.radius_factor(z);
      tube.points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  const auto at = [&](std::uint32_t row, std::uint32_t i) { return row * around + i % around; };
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t i = 0; i < around; ++i) {
      tube.triangles.push_back({at(row, i), at(row, i + 1), at(row + 1, i)});
      tube.triangles.push_back({at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
    }
  tube.patches.assign(tube.triangles.size(), 0);
  return tube;
}

/// Squares of 1 mm in the plane z = 0.
inline TriangleMesh square_sheet(std::uint32_t squares) {
  TriangleMesh sheet;
  for (std::uint32_t row = 0; row <= squares; ++row)
    for (std::uint32_t i = 0; i <= squares; ++i) sheet.points.emplace_back(i, row, 0);
  const auto at = [&](std::uint32_t row, std::uint32_t i) { return row * (squares + 1) + i; };
  for (std::uint32_t row = 0; row < squares; ++row)
    for (std::uint32_t i = 0; i < squares; ++i) {
      sheet.triangles.push_back({at(row, i), at(row, i + 1), at(row + 1, i)});
      sheet.triangles.push_back({at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
    }
  sheet.patches.assign(sheet.triangles.size(), 0);
  return sheet;
}

}  // namespace lumesh::surfaces
