#pragma once
/// @file Vertices that stand so close to others that boundary faces between them cannot have good angles.

#include <vector>

#include "rules.hpp"

namespace lumesh::delaunay {

/// One vertex of each boundary face with an angle below `min_angle_deg`: an end of its shortest edge, or
/// the one in the middle of three along a line. No two of the same tetrahedron; those of worse faces first.
/// @param first  Which end of an edge goes where both might: what did not help once may from the other side.
/// Vertices of rims stay where an opening would have fewer than eight edges around without them.
/// The same vertices, in the same order, whatever their numbers are.
[[nodiscard]] std::vector<VertexId> vertices_of_bad_faces(const TetMesh& mesh, const Rules& rules,
                                                          const Spacing& spacing, double min_angle_deg,
                                                          bool first);

}  // namespace lumesh::delaunay
