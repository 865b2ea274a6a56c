#pragma once
// Colours for vertices that move at the same time.

#include <vector>

#include "work_mesh.hpp"

namespace lumesh {

/// Splits the vertices into classes in which no two share a tetrahedron. Deterministic; each class ascends.
/// Jones and Plassmann 1993, doi:10.1137/0914041, with a hash of the number as the priority.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> colour_vertices(
    const WorkMesh& mesh, const std::vector<std::uint32_t>& vertices);

}  // namespace lumesh
