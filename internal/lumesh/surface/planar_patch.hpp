#pragma once
/// @file Triangles within a simple polygon of the plane, about as long as its edges are near by.

#include <optional>
#include <span>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::surfaces {

/// Whether edges of a closed polygon share nothing but the corner between them; decided exactly.
[[nodiscard]] bool is_simple_polygon(std::span<const Vec2> corners);

/// Whether a point lies within a simple polygon, exactly but for points on its edges.
[[nodiscard]] bool is_inside(std::span<const Vec2> corners, const Vec2& point);

/// The constrained Delaunay triangulation of a polygon without the holes in it, as fill_polygon() takes them.
/// @return Anticlockwise triangles of the corners, then those of the holes; none as there. Cost: the square
/// of the corners.
[[nodiscard]] std::optional<std::vector<Cell<3>>> triangulate_polygon(
    std::span<const Vec2> corners, std::span<const std::vector<Vec2>> holes = {});

struct PlanarPatch {
  std::vector<Vec2> points;        ///< The corners as given, those of the holes, then those inside.
  std::vector<Cell<3>> triangles;  ///< Anticlockwise.
};

/// The constrained Delaunay triangulation of a polygon without the holes in it, refined by circumcentres
/// until triangles are no larger than the edges of the polygon near by, and smoothed. Edges of the polygon
/// stay as they are, so angles are only as good as those allow: at least 25 degrees for even and round ones,
/// at most the polygon's own in its corners.
/// @param holes  Simple polygons that run clockwise, within the first and outside of each other.
/// @return None if the polygon is not simple, or runs clockwise, or holes are none. Cost: about 2 us per
/// triangle, and the square of the corners with holes.
/// Source: Chew 1989, Guaranteed-quality triangular meshes, TR 89-983, Cornell; Lawson 1977.
[[nodiscard]] std::optional<PlanarPatch> fill_polygon(std::span<const Vec2> corners,
                                                      std::span<const std::vector<Vec2>> holes = {});

}  // namespace lumesh::surfaces
