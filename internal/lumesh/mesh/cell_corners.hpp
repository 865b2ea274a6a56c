#pragma once
/// @file The corners and edges of each shape of cell, and whether a corner is turned inside out.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// A corner and its three neighbours, seen right-handed, by their places in the cell in VTK order.
using LocalCorner = std::array<std::uint8_t, 4>;
inline constexpr std::array<LocalCorner, 1> kTetrahedronCorners = {{{0, 1, 2, 3}}};  // All are alike.
/// Corners of the pyramid's base; at the apex four edges meet.
inline constexpr std::array<LocalCorner, 4> kPyramidCorners = {
    {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
inline constexpr std::array<LocalCorner, 6> kPrismCorners = {
    {{0, 2, 1, 3}, {1, 0, 2, 4}, {2, 1, 0, 5}, {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}}};
inline constexpr std::array<LocalCorner, 8> kHexahedronCorners = {{{0, 1, 3, 4},
                                                                   {1, 2, 0, 5},
                                                                   {2, 3, 1, 6},
                                                                   {3, 0, 2, 7},
                                                                   {4, 7, 5, 0},
                                                                   {5, 4, 6, 1},
                                                                   {6, 5, 7, 2},
                                                                   {7, 6, 4, 3}}};

/// Corners, with their neighbours, of a cell with `corners` corners: 4, 5, 6 or 8.
[[nodiscard]] constexpr std::span<const LocalCorner> corners_of_cell(std::size_t corners) {
  return corners == 5   ? std::span<const LocalCorner>(kPyramidCorners)
         : corners == 6 ? std::span<const LocalCorner>(kPrismCorners)
         : corners == 8 ? std::span<const LocalCorner>(kHexahedronCorners)
                        : std::span<const LocalCorner>(kTetrahedronCorners);
}

/// Edges by the places of their ends in the cell; kTetEdges are those of tetrahedra.
inline constexpr std::array<std::array<int, 2>, 8> kPyramidEdges = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};
inline constexpr std::array<std::array<int, 2>, 9> kPrismEdges = {
    {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
inline constexpr std::array<std::array<int, 2>, 12> kHexahedronEdges = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Whether the edges at any corner span no positive volume: such a cell has a Jacobian that is not positive.
[[nodiscard]] inline bool has_turned_corner(std::span<const Vec3> points,
                                            std::span<const std::uint32_t> cell) {
  const std::span<const LocalCorner> corners = corners_of_cell(cell.size());
  return std::ranges::any_of(corners, [&](const LocalCorner& c) {
    const Vec3& at = points[cell[c[0]]];
    const Vec3 u = points[cell[c[1]]] - at, v = points[cell[c[2]]] - at, w = points[cell[c[3]]] - at;
    return !(u.cross(v).dot(w) > 0);
  });
}

}  // namespace lumesh
