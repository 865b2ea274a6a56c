#pragma once
// How a surface passes through a cell of a grid, by which of the cell's corners are inside.

#include <array>
#include <cstdint>
#include <vector>

namespace lumesh::surfaces {

/// Edges of a cell, each by its lower corner and its axis. Corner n has the coordinates (n & 1, n >> 1 & 1,
/// n >> 2).
struct CellEdge {
  std::uint8_t corner, axis;
};
inline constexpr std::array<CellEdge, 12> kCellEdges = {
    {{0, 0}, {2, 0}, {4, 0}, {6, 0}, {0, 1}, {1, 1}, {4, 1}, {5, 1}, {0, 2}, {1, 2}, {2, 2}, {3, 2}}};

/// Edges along which a loop passes, in order, anticlockwise seen from outside.
using CellLoop = std::vector<std::uint8_t>;

/// The loops of each of the 256 sets of inner corners (bit n: corner n), after Lorensen and Cline 1987,
/// doi:10.1145/37402.37422. Where a face has two inner corners across from each other they are apart, in both
/// cells of the face, so that loops of cells close to a manifold.
[[nodiscard]] const std::array<std::vector<CellLoop>, 256>& cell_loops();

}  // namespace lumesh::surfaces
