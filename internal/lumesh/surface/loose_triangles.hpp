#pragma once
/// @file Triangles at the ragged edge of a surface that hang together with it at corners only.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Triangles, ascending, of parts (connected over edges) that are neither a vessel nor a lid of one: a disc
/// of at most 20 triangles without an inner vertex, whose area is at most a thousandth of the whole. Cutting
/// tools leave them where they take away triangles by their corners. Cost: linear,
/// but for one sort. Threads: parallel inside, the same for every thread count.
[[nodiscard]] std::vector<std::uint32_t> loose_triangles(const TriangleMesh& surface);

}  // namespace lumesh::surfaces
