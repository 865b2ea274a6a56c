#pragma once
// Names for the parts of the boundary.

#include "boundary_model.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct PatchAssignment {
  std::vector<Patch> patches;
  std::vector<std::int32_t> of_triangle;
};

/// "wall" (or "wall_L" where there are several labels), "interface_A_B", and one patch for each connected
/// opening in a cut plane: the largest is "inlet_1", the others "outlet_1", "outlet_2", … by falling area.
[[nodiscard]] PatchAssignment name_patches(const BoundaryModel& boundary, const std::vector<Vec3>& positions,
                                           const ImageDomain& domain);

}  // namespace lumesh
