#pragma once
// Rims of openings: which outer triangles belong to an opening and which to the wall beside it.

#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Gives triangles beside rims the outside material whose surface is nearest to them: the cut plane where it
/// cuts the object, or the wall. Where a wall meets a cut plane at a small angle, the lattice's rim may be
/// some edges away from the true one, further than vertices can be carried. The topology of each label's
/// openings and walls stays.
void choose_rims(const WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain);

}  // namespace lumesh::fitting
