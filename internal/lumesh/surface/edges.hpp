#pragma once
/// @file Triangle surfaces that need not be closed: equal points made one, neighbours over edges, and
/// triangles turned alike.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Makes equal points one, and leaves out unused points and triangles whose corners are not three places.
/// @param patches  One per triangle, or none: all 0.
/// @return Points in the order in which the triangles use them. Threads: parallel inside, the same for every
/// thread count.
[[nodiscard]] TriangleMesh weld(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                                std::span<const std::int32_t> patches);

/// Makes corners at almost one place one where hardly two triangles share any, as where a file has three of
/// its own for each triangle, each rounded its own way: no farther apart than 1e-4 of the diagonal and a
/// quarter of short sides. Others stay as they are.
/// @param points  Those at almost one place become equal.
/// @return How far a point moved at most; 0 where nothing was done. Cost: O(n log n) there, else nothing.
double join_torn_corners(std::vector<Vec3>& points, std::span<const Cell<3>> triangles);

/// Instead of a neighbour: of an edge with one triangle, and of one with more than two.
inline constexpr std::uint32_t kOpenEdge = ~0U, kCrowdedEdge = ~0U - 1;

/// For each triangle, those behind its edges, from corner i to the next; kOpenEdge or kCrowdedEdge where not
/// one is there.
using EdgeNeighbours = std::vector<std::array<std::uint32_t, 3>>;

/// Threads: parallel inside, the same for every thread count.
[[nodiscard]] EdgeNeighbours edge_neighbours(std::span<const Cell<3>> triangles);

/// Connected part of each triangle, over edges of two triangles; numbered by their first triangles.
struct Parts {
  std::vector<std::uint32_t> of_triangle;
  std::uint32_t count = 0;
};

/// Turns the triangles of each part like its first one. Where a part has one side only, as a Moebius strip,
/// some stay turned against their neighbours.
Parts turn_alike(TriangleMesh& surface);
/// The same where the neighbours are known. @param neighbours  Of the triangles as they are given.
Parts turn_alike(std::vector<Cell<3>>& triangles, const EdgeNeighbours& neighbours);

/// Whether a triangle goes along the edge from one point to another.
[[nodiscard]] bool runs_along(const Cell<3>& corners, std::uint32_t from, std::uint32_t to);

}  // namespace lumesh::surfaces
