#pragma once
// Protrusions and clefts that no vertex could be attracted to: single tetrahedra are added or change sides
// there.

#include <span>

#include "boundary_stars.hpp"
#include "deviation.hpp"
#include "fit_setting.hpp"

namespace lumesh::fitting {

struct ProtrusionOptions {
  AngleLimits limits;
  std::span<const std::uint8_t> fixed;  ///< Flag per vertex whose star stays as it is; later ones are free.
  bool allows_temporary_deviation =
      false;  ///< Also takes what leaves the surface up to 1.6 voxels from the boundary for now.
};

/// For each deviation, the largest first: at a protrusion towards the background a tetrahedron is put on a
/// triangle nearby,
/// with a new vertex at the boundary, or into the valley between two triangles; elsewhere a tetrahedron
/// behind a triangle goes to the other material, and its far vertex to the boundary. Only where the angles
/// keep their limits, the boundary stays a manifold that does not cut itself, and the surface comes closer.
/// Rebuilds the mesh's stars, but not its neighbours, which it does not need. New vertices come last.
/// @return Number of deviations that a tetrahedron was added or changed for.
std::size_t grow_protrusions(WorkMesh& mesh, BoundaryModel& boundary, const BoundaryStars& surface,
                             const ImageDomain& domain, const std::vector<Deviation>& deviations,
                             const ProtrusionOptions& options);

}  // namespace lumesh::fitting
