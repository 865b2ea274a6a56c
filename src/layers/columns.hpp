#pragma once
/// @file Columns as high as their cells allow.

#include "heights.hpp"

namespace lumesh::layers {

/// Surface and directions that the points of layers are computed from.
struct ExtrusionFrame {
  const LayerSurface& surface;
  const Directions& directions;

  /// The upper end of layer k of a column, or of its last one (k = -1: the surface).
  [[nodiscard]] Vec3 point(const Columns& columns, std::size_t v, int k) const {
    return point(columns, v, columns.profile.filling(columns.fraction[v]), k);
  }
  [[nodiscard]] Vec3 point(const Columns& columns, std::size_t v, const LayerProfile::Filling& filling,
                           int k) const {
    if (k < 0) return surface.points[v];
    return end(v, columns.profile.upper_end(filling, k) * columns.wanted_mm[v]);
  }
  /// The upper end of a column.
  [[nodiscard]] Vec3 tip(const Columns& columns, std::size_t v) const { return end(v, columns.length_mm(v)); }
  /// The upper end of a column of this length.
  [[nodiscard]] Vec3 end(std::size_t v, double length_mm) const {
    return surface.points[v] + length_mm * directions.of[v];
  }
};

/// Shortens columns until every cell is positively oriented by the exact predicate and of fair shape: its
/// upper triangle nearly parallel to the lower one and not much smaller, its columns not lying down. Columns
/// that no length makes so go.
void keep_cells_well_shaped(const ExtrusionFrame& frame, Columns& columns);

/// Shortens columns until the skin neither cuts itself nor any other part of the outside.
/// @param outside  The mesh that is grown on; null where layers grow into it: its deformation tells then.
void keep_skin_simple(const ExtrusionFrame& frame, const TetMesh* outside, Columns& columns);

}  // namespace lumesh::layers
