#pragma once
/// @file The faces of each shape of cell, and what triangles among them are to each other.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Corners of a face by their place in the cell, as seen from outside anticlockwise, in VTK order; triangles
/// repeat their last corner.
using LocalFace = std::array<std::uint8_t, 4>;
inline constexpr std::array<LocalFace, 4> kTetrahedronFaces = {
    {{1, 2, 3, 3}, {0, 3, 2, 2}, {0, 1, 3, 3}, {0, 2, 1, 1}}};
inline constexpr std::array<LocalFace, 5> kPyramidFaces = {
    {{0, 3, 2, 1}, {0, 1, 4, 4}, {1, 2, 4, 4}, {2, 3, 4, 4}, {3, 0, 4, 4}}};
inline constexpr std::array<LocalFace, 5> kPrismFaces = {
    {{0, 1, 2, 2}, {3, 5, 4, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
inline constexpr std::array<LocalFace, 6> kHexFaces = {
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

/// Faces of a cell with `corners` corners: 4, 5, 6 or 8.
[[nodiscard]] constexpr std::span<const LocalFace> faces_of_cell(std::size_t corners) {
  return corners == 5   ? std::span<const LocalFace>(kPyramidFaces)
         : corners == 6 ? std::span<const LocalFace>(kPrismFaces)
         : corners == 8 ? std::span<const LocalFace>(kHexFaces)
                        : std::span<const LocalFace>(kTetrahedronFaces);
}

/// Corners in ascending order.
[[nodiscard]] inline Cell<3> sorted_corners(Cell<3> corners) {
  if (corners[0] > corners[1]) std::swap(corners[0], corners[1]);
  if (corners[1] > corners[2]) std::swap(corners[1], corners[2]);
  if (corners[0] > corners[1]) std::swap(corners[0], corners[1]);
  return corners;
}

/// Whether two triangles are one face as its two sides see it.
[[nodiscard]] inline bool are_opposite_sides(const Cell<3>& a, const Cell<3>& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (a[0] == b[i]) return a[1] == b[(i + 2) % 3] && a[2] == b[(i + 1) % 3];
  return false;
}

/// "(3, 7, 12)", for messages.
template <std::size_t N>
[[nodiscard]] std::string corners_text(const Cell<N>& vertices) {
  std::string list = "(";
  for (const std::uint32_t v : vertices) list += (list.size() > 1 ? ", " : "") + std::to_string(v);
  return list + ")";
}

}  // namespace lumesh
