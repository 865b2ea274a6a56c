#pragma once
// Flat ends of vessels that no sharp edge parts from the wall all around.

#include <cstdint>
#include <vector>

#include "closed_surface.hpp"
#include "feature_regions.hpp"

namespace lumesh::surfaces {

struct MissedEnd {
  Vec3 centre_mm = Vec3::Zero();
  double radius_mm = 0;
  double least_turn_deg = 0;  // At the edge around it.
  std::uint32_t region = 0;   // Its number.
};

/// Parts of regions in one plane to which a tube-like wall runs up from all sides, as at an end that is cut
/// off very obliquely: on one side the surface turns by less than the feature angle there.
[[nodiscard]] std::vector<MissedEnd> missed_ends(const ClosedSurface& surface, const FeatureRegions& regions);

}  // namespace lumesh::surfaces
