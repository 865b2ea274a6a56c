#pragma once
/// @file Rims: where a triangle surface ends, and what ends there.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::surfaces {

/// Rims by their first vertices. Triangles must be turned alike (turn_alike()). A loop that passes a vertex
/// twice, as where two rims touch, is two of them. Edges with more than two triangles are not looked at;
/// chains that end at those are left out.
[[nodiscard]] std::vector<Rim> find_rims(const TriangleMesh& surface);

/// The rim through these vertices, measured.
[[nodiscard]] Rim measured_rim(std::span<const Vec3> points, std::vector<std::uint32_t> vertices);

/// The place of an opening that lies on another one, back to back, if there is one: pieces of a wall end
/// there that do not match, as no two vessels do. @param count  Of rims. @param opening  The rim of a number,
/// whose normal points out of the object; null if it is no opening.
[[nodiscard]] std::optional<Vec3> place_of_seam(std::size_t count,
                                                const std::function<const Rim*(std::size_t)>& opening);

/// Turns the parts of a surface (turn_alike()) that enclose a negative volume, rims closed by fans.
/// @param rims  Of the surface; turned with it.
void turn_outwards(TriangleMesh& surface, std::vector<Rim>& rims);

}  // namespace lumesh::surfaces
