#pragma once
/// @file Columns as high as their cells allow.

#include <vector>

#include "heights.hpp"

namespace lumesh::layers {

/// What the points of layers are computed from.
struct Growth {
  const LayerSurface& surface;
  const Directions& directions;
  std::vector<double> levels;  ///< Of each layer's upper end, as a share of the column.

  /// The upper end of layer k of a column (k = -1: the surface).
  [[nodiscard]] Vec3 point(const Columns& columns, std::size_t v, int k) const {
    if (k < 0) return surface.points[v];
    return end(v, columns.length_mm(v) * levels[static_cast<std::size_t>(k)]);
  }
  /// Of a column so long.
  [[nodiscard]] Vec3 end(std::size_t v, double length_mm) const {
    return surface.points[v] + length_mm * directions.of[v];
  }
};

/// Shortens columns until every cell is positively oriented by the exact predicate and of fair shape: its
/// upper triangle nearly parallel to the lower one and not much smaller, its columns not lying down. What
/// cannot be mended goes without layers.
void keep_cells_well_shaped(const Growth& growth, Columns& columns);

/// Shortens columns until the skin neither cuts itself nor any other part of the outside.
/// @param outside  The mesh that is grown on; null where layers grow into it, and it will tell by itself.
void keep_skin_simple(const Growth& growth, const TetMesh* outside, Columns& columns);

}  // namespace lumesh::layers
