#pragma once
// Edges of a surface halved, and the triangles at them divided.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Halves edges. The last piece of each triangle takes its place, the others follow at the end.
/// @param edges  Keys (edge_key()), ascending. @return The triangles whose pieces follow, one entry for each.
std::vector<std::uint32_t> halve_edges(TriangleMesh& surface, const std::vector<std::uint64_t>& edges);

}  // namespace lumesh::surfaces
