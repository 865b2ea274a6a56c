#pragma once
// Tips and clefts that no vertex could be drawn to: single tetrahedra are added or change sides there.

#include "anchors.hpp"
#include "surface_stars.hpp"

namespace lumesh {

struct AngleLimits {
  double min_deg;
  double max_deg;
};

/// For each missed probe, the worst first: at a tip towards the background a tetrahedron is put on a triangle
/// nearby, with a new vertex at the boundary; elsewhere a tetrahedron behind such a triangle goes to the
/// other material, and its far vertex to the boundary. Only where the angles keep their limits, the boundary
/// stays a manifold that does not cut itself, and the probe comes closer. Rebuilds the mesh's stars; its
/// neighbours are gone. New vertices come last.
std::size_t reach_missed_tips(WorkMesh& mesh, BoundaryModel& boundary, const SurfaceStars& surface,
                              const TriangleTree& tree, const ImageDomain& domain,
                              const std::vector<Probe>& probes, const std::vector<Anchors::Miss>& misses,
                              const AngleLimits& limits);

}  // namespace lumesh
