#pragma once
// Narrow gaps of the surface that the voxels do not have are closed from their ends, as by a zip.

#include <cstdint>
#include <vector>

#include "deviation.hpp"
#include "fit_setting.hpp"
#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Near the first outlier triangle where it works: merges the far corners of two boundary triangles that
/// share an edge and enclose a narrow valley inside the label, so that both triangles vanish. Only where the
/// angles keep their limits and the mesh stays a manifold. Rebuilds the stars. The vertex that is left over
/// has no tetrahedra; other triangles get other numbers.
/// @param fixed  Flag per vertex that must stay; later ones may move.
/// @return False if nothing was done.
bool close_gap(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
               const std::vector<Deviation>& deviations, const std::vector<std::uint8_t>& fixed,
               const AngleLimits& limits);

}  // namespace lumesh::fitting
