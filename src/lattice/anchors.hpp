#pragma once
// Vertices sent to places of the boundary that the surface passes by.

#include <cstdint>
#include <optional>
#include <vector>

#include "misses.hpp"

namespace lumesh {

/// Sends the nearest free vertex to each missed probe, but to one of those within 1.5 voxels of each other
/// only. The place is on the vertex's own boundary, which a stray's probe need not be. Vertices keep an
/// anchor until they get another one.
/// @param anchors_mm  The place of each vertex that has one.
/// @return The vertices with a new anchor.
std::vector<std::uint32_t> set_anchors(const WorkMesh& mesh, const BoundaryModel& boundary,
                                       const ImageDomain& domain, const std::vector<Miss>& misses,
                                       std::vector<std::optional<Vec3>>& anchors_mm);

}  // namespace lumesh
