#pragma once
// Colours for vertices that move at the same time.

#include <vector>

#include "boundary_model.hpp"
#include "work_mesh.hpp"

namespace lumesh {

/// Classes of vertices; each ascends.
using VertexColours = std::vector<std::vector<std::uint32_t>>;

/// Boundary vertices and three rings of others behind them, ascending.
[[nodiscard]] std::vector<std::uint32_t> vertices_near_boundary(const WorkMesh& mesh,
                                                                const BoundaryModel& boundary);

/// Splits the vertices into classes in which no two share a tetrahedron. Deterministic. Jones and Plassmann
/// 1993, doi:10.1137/0914041, with a hash of the number as the priority.
[[nodiscard]] VertexColours colour_vertices(const WorkMesh& mesh, const std::vector<std::uint32_t>& vertices);

/// Follows a mesh that has lost tetrahedra: `kept` are the old numbers of its vertices, ascending.
void keep_vertices(VertexColours& colours, const std::vector<std::uint32_t>& kept);

}  // namespace lumesh
