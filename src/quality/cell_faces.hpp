#pragma once
/// @file All triangles of all cells, sorted so that equal ones stand together.

#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/parallel/key_table.hpp"

namespace lumesh::quality {

/// A triangle as one cell sees it.
struct CellFace {
  Cell<3> corners;        ///< Ascending.
  std::uint32_t cell;     ///< Number in AllCells.
  std::uint32_t flipped;  ///< 1 if ascending order turns the triangle over, else 0.
  auto operator<=>(const CellFace&) const = default;

  /// Corners as seen from outside the cell.
  [[nodiscard]] Cell<3> outward() const {
    return flipped == 0 ? corners : Cell<3>{corners[0], corners[2], corners[1]};
  }
};

inline CellFace make_cell_face(Cell<3> corners, std::uint32_t cell) {
  std::uint32_t flipped = 0;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (corners[i] <= corners[j]) return;
    std::swap(corners[i], corners[j]);
    flipped ^= 1;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return {corners, cell, flipped};
}

inline parallel::KeyTable<CellFace> collect_faces(const MeshView& mesh) {
  const AllCells cells(mesh);
  return {cells.size(), mesh.points.size(),
          [&](std::size_t cell, const auto& take) {
            for (const Cell<3>& corners : cells.triangles(cell))
              take(make_cell_face(corners, static_cast<std::uint32_t>(cell)));
          },
          [](const CellFace& face) { return face.corners[0]; }};
}

inline bool same_corners(const CellFace& a, const CellFace& b) {
  return a.corners == b.corners;
}

}  // namespace lumesh::quality
