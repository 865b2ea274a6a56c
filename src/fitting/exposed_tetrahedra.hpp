#pragma once
// Exposed tetrahedra, with two or three faces on the outer boundary: they keep the boundary from becoming
// smooth.

#include <cstdint>
#include <span>

#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Drops tetrahedra with two or three faces towards the same outside material where the two faces are nearly
/// coplanar or a corner hangs outside the object, if the boundary stays a manifold of the same topology.
/// @return The vertices that are left, by their old numbers, ascending; those are their new order.
std::vector<std::uint32_t> remove_exposed(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain);

/// Drops, under the same conditions, tetrahedra with a corner beyond a cut plane: where a wall grazes the
/// image's border, those whose other corners are in the plane cannot get within.
void remove_beyond_cuts(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain);

/// Drops, under the same conditions, tetrahedra with three faces towards the outside, one of them among these
/// boundary triangles, that stand on a face near the boundary. Needs the mesh's stars.
void remove_exposed_at(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
                       std::span<const std::uint32_t> triangles);

}  // namespace lumesh::fitting
