#pragma once
// Vertices that were pulled past their neighbours, put back among them.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Vertices that were pulled past their neighbours, so that triangles at them cross others: each is moved to
/// where the planes of the wall around its triangles meet, and in these to the middle of its neighbours, or
/// as far of the way as the triangles need not move farther than asked. Moved are those after which none of
/// their triangles crosses or lies back on any other.
/// @param is_bad  Of each triangle, whether it crosses others or lies back on one.
/// @return The vertices that were moved.
/// Threads: parallel inside, the same for every thread count. Cost: linear, and about 1 ms per vertex tried.
std::vector<std::uint32_t> put_back_strays(TriangleMesh& surface, std::span<const std::uint8_t> is_bad,
                                           double max_distance_mm);

}  // namespace lumesh::surfaces
