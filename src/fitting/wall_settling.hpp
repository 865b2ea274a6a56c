#pragma once
// The last step of the fit: vertices of the boundary come to stand exactly where they should.

#include "fit_setting.hpp"
#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Carries the vertices of smooth boundaries, those nearer than a quarter of a voxel, to their places: on the
/// image's boundary, and over it by the sagitta of the triangles around, so that labels have the volume that
/// their boundaries enclose (operators::settle()); where many stay short of these, as in thin parts, all
/// stand evenly farther out. What is farther off could not get nearer, and stays. No angle passes its limit.
void settle_wall(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                 const AngleLimits& limits);

}  // namespace lumesh::fitting
