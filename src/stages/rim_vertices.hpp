#pragma once
// Vertices at the rims of openings that stand off the vessel's section.

#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A line for each patch of openings with a vertex on its rim that is more than half the domain's resolution
/// away, within the plane, from where the vessel ends there: name, place and distance of the worst. Where the
/// rim's edges are long its vertices may stand over the curve by what they cut off it.
/// @param domain  The one that was meshed. Cost: some 16 looks at the domain for each vertex of rims.
[[nodiscard]] std::vector<std::string> notes_on_rims(const MeshView& mesh, const Domain& domain);

}  // namespace lumesh
