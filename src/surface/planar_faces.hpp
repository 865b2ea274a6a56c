#pragma once
// Faces into which lines divide a polygon of the plane, as triangles.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::surfaces {

/// Triangles of a polygon of which lines between points are edges.
/// @param places  Of all points. @param rim  Points of the polygon, anticlockwise. @param lines  Pairs of
/// points, with nothing between them; those that end within a face divide nothing and are left out.
/// @return None if lines cross or meet themselves at points, or a face has thousands of points, or a hundred
/// holes. Cost: the square of the points of a face, once for itself and for each hole.
[[nodiscard]] std::optional<std::vector<Cell<3>>> triangulate_faces(
    std::span<const Vec2> places, std::span<const std::uint32_t> rim,
    std::span<const std::array<std::uint32_t, 2>> lines);

}  // namespace lumesh::surfaces
