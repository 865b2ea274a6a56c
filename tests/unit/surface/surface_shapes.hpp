#pragma once
/// @file Open surfaces that tests begin with.

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Around the z axis, open at both ends, triangles outwards if the profile goes up.
/// @param profile  Radius and z.
inline TriangleMesh revolved(const std::vector<Vec2>& profile, std::uint32_t around) {
  TriangleMesh tube;
  for (const Vec2& at : profile)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      tube.points.emplace_back(at.x() * std::cos(angle), at.x() * std::sin(angle), at.y());
    }
  const auto at = [&](std::size_t row, std::uint32_t i) {
    return static_cast<std::uint32_t>(row) * around + i % around;
  };
  for (std::size_t row = 0; row + 1 < profile.size(); ++row)
    for (std::uint32_t i = 0; i < around; ++i) {
      tube.triangles.push_back({at(row, i), at(row, i + 1), at(row + 1, i)});
      tube.triangles.push_back({at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
    }
  tube.patches.assign(tube.triangles.size(), 0);
  return tube;
}

struct TubeShape {
  double radius_mm = 3, length_mm = 20;
  std::uint32_t around = 48;
};

/// From z = 0 on, triangles about as long as wide.
inline TriangleMesh open_tube(const TubeShape& shape) {
  const double step_mm = 2 * std::numbers::pi * shape.radius_mm / shape.around;
  const auto rows = static_cast<int>(std::max(2.0, std::round(shape.length_mm / step_mm)));
  std::vector<Vec2> profile;
  for (int row = 0; row <= rows; ++row) profile.emplace_back(shape.radius_mm, row * shape.length_mm / rows);
  return revolved(profile, shape.around);
}

/// Adds a surface beside another one, with points of its own and patch 0.
template <class Part>
void append_surface(const Part& part, TriangleMesh& surface) {
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  surface.points.insert(surface.points.end(), part.points.begin(), part.points.end());
  for (const auto& [a, b, c] : part.triangles) surface.triangles.push_back({a + first, b + first, c + first});
  surface.patches.resize(surface.triangles.size(), 0);
}

/// Moves the last ring of a surface of revolution along z, by the number of its points.
inline TriangleMesh with_end_moved(TriangleMesh tube, std::uint32_t around,
                                   const std::function<double(std::uint32_t)>& by_mm) {
  const std::size_t first = tube.points.size() - around;
  for (std::uint32_t i = 0; i < around; ++i) tube.points[first + i].z() += by_mm(i);
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
