#pragma once
// Ends of vessels in one piece, which creases divide where they are not quite flat.

#include <cstdint>
#include <vector>

#include "closed_surface.hpp"
#include "feature_regions.hpp"

namespace lumesh::surfaces {

/// Triangles of each end that sharp edges divide: fans and needles over a ragged or noisy rim
/// have such edges between them, though all their corners are in one plane, as RegionShape asks. Together
/// they are a flat end, which the wall leaves at an angle; patches of the file stay apart. Cost: a few passes
/// over the surface, more where it has very many regions.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> divided_ends(const ClosedSurface& surface,
                                                                   const FeatureRegions& regions);

/// An end of a vessel but for how far it is off a plane.
struct BentEnd {
  Vec3 centre_mm = Vec3::Zero();
  double radius_mm = 0;
  double bent_mm = 0;        // Off its plane.
  std::uint32_t region = 0;  // Of one of its triangles.
};
[[nodiscard]] std::vector<BentEnd> bent_ends(const ClosedSurface& surface, const FeatureRegions& regions);

/// The regions, those of one end as one.
[[nodiscard]] FeatureRegions with_whole_ends(const ClosedSurface& surface, FeatureRegions regions);

}  // namespace lumesh::surfaces
