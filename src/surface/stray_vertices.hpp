#pragma once
// Vertices that were pulled past their neighbours, put back among them.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::surfaces {

struct StraysPutBack {
  std::vector<std::uint32_t> vertices;      ///< Vertices that were moved.
  std::vector<std::uint32_t> far_vertices;  ///< Vertices of those that moved farther than asked.
  FarthestPoint farthest;  ///< Distance of what was at these to what is now, and where one was.
};

/// Vertices that were pulled past their neighbours, so that triangles at them cross others: each is moved to
/// where the planes of the wall around its triangles meet, and in these to the middle of its neighbours, or
/// as far of the way as the triangles need not move farther than asked; where that is less than
/// three quarters, and they cross others a few edges away only, all of it, up to three times the distance
/// asked: there the place of the vertex is the fault. Moved are those after which none of their triangles
/// crosses or lies back on any other.
/// @param is_bad  Of each triangle, whether it crosses others or lies back on one.
/// Threads: parallel inside, the same for every thread count. Cost: linear, and about 1 ms per vertex tried.
StraysPutBack put_back_strays(TriangleMesh& surface, std::span<const std::uint8_t> is_bad,
                              double max_distance_mm);

}  // namespace lumesh::surfaces
