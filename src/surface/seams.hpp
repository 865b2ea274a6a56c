#pragma once
// Seams along which two pieces of a wall were made apart, so that their vertices do not match.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

struct JoinedSeams {
  std::uint64_t vertices = 0;            ///< That were joined with a vertex or an edge on the other side.
  std::vector<std::uint32_t> given;      ///< For each triangle the one of which it is the whole or a piece.
  std::vector<std::uint8_t> is_changed;  ///< For each triangle, whether a corner was moved or put in.
};

/// Joins vertices on the rim of a wall with those across a seam: one vertex where two are the nearest to each
/// other, else edges across are divided there. They lie no farther apart than a distance and a quarter of the
/// edges of the rim there, and the walls lie on different sides of the seam, as they do not where the ends of
/// two vessels lie side by side. After Attene 2010, doi:10.1007/s00371-010-0416-3.
/// @param surface  Points at one place are one, triangles have areas. Cost: about 1 us per edge of rims, and
/// one sort of edges.
JoinedSeams join_seams(TriangleMesh& surface, double max_distance_mm);

}  // namespace lumesh::surfaces
