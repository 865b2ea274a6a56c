#pragma once
// Narrow slits of the surface that the voxels do not have are closed from their ends, as by a zip.

#include <cstdint>
#include <vector>

#include "boundary_model.hpp"
#include "misses.hpp"
#include "star_quality.hpp"

namespace lumesh {

/// Where the surface runs through a label's inside, merges the far corners of two boundary triangles that
/// share an edge and enclose a narrow valley, so that both triangles vanish. Only where the angles keep their
/// limits and the mesh stays a manifold. Rebuilds the stars. The vertex that is left over has no tetrahedra.
/// @param fixed  Flag per vertex that must stay; later ones may move.
/// @return The number of valleys closed.
std::size_t close_slits(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
                        const std::vector<Miss>& misses, const std::vector<std::uint8_t>& fixed,
                        const AngleLimits& limits);

}  // namespace lumesh
