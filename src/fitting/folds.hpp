#pragma once
// Folds of the wall: triangles that face against the domain's boundary.

#include "fit_setting.hpp"
#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

/// Whether a triangle is of the wall, and the cosine between its normal and that of the domain's boundary is
/// below a bound: 0 for folds.
[[nodiscard]] bool is_steep_wall(const WorkMesh& mesh, const BoundaryTriangle& triangle,
                                 const ImageDomain& domain, double min_cosine);

/// Takes folds out of the walls as far as the limits of the angles allow: drops tetrahedra that stand on a
/// wall with a folded face, then moves the vertices around the folds that are left, anchored ones too. The
/// surface comes to cross itself nowhere. Does nothing where the boundary keeps every voxel's side.
void remove_folds(WorkMesh& mesh, BoundaryModel& boundary, const FitSetting& setting);

}  // namespace lumesh::fitting
