#pragma once
// Vertices sent to places of the boundary that the surface passes by.

#include <cstdint>
#include <optional>
#include <vector>

#include "deviation.hpp"
#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Sends the nearest free vertex to each deviation's probe, but to one of those within 1.5 voxels of each
/// other only. The anchor is on the vertex's own boundary, which the probe of an outlier triangle need not
/// be. Vertices keep an anchor until they get another one.
/// @param anchors_mm  The place of each vertex that has one.
/// @return The vertices with a new anchor.
std::vector<std::uint32_t> set_anchors(const WorkMesh& mesh, const BoundaryModel& boundary,
                                       const ImageDomain& domain, const std::vector<Deviation>& deviations,
                                       std::vector<std::optional<Vec3>>& anchors_mm);

}  // namespace lumesh::fitting
