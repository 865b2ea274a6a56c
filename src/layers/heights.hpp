#pragma once
/// @file Heights of the columns of layers, before any cell is looked at.

#include <vector>

#include "directions.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh::layers {

/// Heights of the layers' upper ends over the surface, from the first one, in the unit of the options.
/// @throws Error{kBadInput} if no growth makes the thickness out of these layers.
[[nodiscard]] std::vector<double> height_schedule(const LayerOptions& options);

/// The outside of a mesh, for queries of near triangles.
struct Outside {
  TriangleTree tree;
  std::vector<Vec3> normals;  ///< Normals of the triangles, out of the mesh.

  Outside(const TetMesh& mesh, const BoundaryFaces& faces);

 private:
  Outside(std::span<const Vec3> points, const std::vector<Cell<3>>& triangles);
};

/// Columns over a surface. A column of fraction f has its layers at f times the heights wanted.
struct Columns {
  std::vector<double> wanted_mm;  ///< Length along the direction.
  std::vector<double> fraction;   ///< 0 to 1; 0: no layers here.
  std::vector<LayerLimit> limit;

  [[nodiscard]] double length_mm(std::size_t v) const { return fraction[v] * wanted_mm[v]; }
  /// Makes a column shorter, for a reason.
  void shorten(std::size_t v, double to_mm, LayerLimit why);
};

/// Length of the columns as wanted, for each vertex.
/// @param thickness  Thickness of all layers, in the unit of the options.
[[nodiscard]] Columns wanted_columns(const LayerSurface& surface, const Directions& directions,
                                     const LayerOptions& options, double thickness, const Outside& outside);

/// Shortens columns whose upper ends would come too near to another part of the outside.
/// @param side  1 where layers grow out of the mesh, -1 into it: there some of the mesh has to be left.
void keep_from_other_sides(const LayerSurface& surface, const Directions& directions, const Outside& outside,
                           double side, Columns& columns);

/// Shortens columns until lengths differ by no more than a share of the edge between them.
void smooth_lengths(const LayerSurface& surface, Columns& columns);

}  // namespace lumesh::layers
