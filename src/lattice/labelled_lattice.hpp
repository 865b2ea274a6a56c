#pragma once
// The materials of lattice tetrahedra, and the mesh of those that matter.

#include "bcc.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/fitting/work_mesh.hpp"
#include "refinement.hpp"

namespace lumesh {

/// Gives every lattice tetrahedron the material that fills most of it, keeps those of the object and one ring
/// of others around it, and numbers vertices and tetrahedra along the Morton curve.
[[nodiscard]] fitting::WorkMesh make_work_mesh(bcc::Lattice lattice, const LatticeFrame& frame,
                                               const ImageDomain& domain);

}  // namespace lumesh
