#pragma once
// The triangles at a rim.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/surface/rims.hpp"

namespace lumesh::surfaces {

/// For each edge of each rim, from vertex i to the next, the triangle that has it. Cost: one pass over the
/// surface.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> rim_triangles(const TriangleMesh& surface,
                                                                    std::span<const Rim> rims);

/// The patch that most of some triangles have.
[[nodiscard]] std::int32_t commonest_patch(const TriangleMesh& surface,
                                           std::span<const std::uint32_t> triangles);

/// Angles between a surface and its cap: wanted, and such that the cap at least does not lie on the surface.
inline constexpr double kGoodAngleDeg = 20, kMinAngleDeg = 1;

/// Whether the surface makes an angle with the rim's plane all around, so that a cap does not fold onto it.
[[nodiscard]] bool leaves_plane_at_angle(const TriangleMesh& surface, const Rim& rim, double min_angle_deg);

/// Mean cosine between the normal of a rim and those of the triangles at it: low where a wall runs up to the
/// rim, 1 where it lies in the wall.
/// @param triangles  At the edges of the rim, as rim_triangles() has them.
[[nodiscard]] double cosine_to_wall(const TriangleMesh& surface, const Rim& rim,
                                    std::span<const std::uint32_t> triangles);
inline constexpr double kAcrossWall = 0.7;  ///< Below this the rim ends a wall.

}  // namespace lumesh::surfaces
