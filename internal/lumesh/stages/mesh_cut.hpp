#pragma once
/// @file Parts of finished meshes cut off by planes.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// The option `cut_planes`: planes x, y, z, nx, ny, nz in mm (LPS).
void describe_planes(OptionList& list, std::vector<CutPlane>& planes);

struct CutMesh {
  struct Opening {
    std::string name;
    double area_mm2 = 0;
    Vec3 centre_mm = Vec3::Zero();
    double min_angle_deg = 180;  ///< Between it and the walls at its rim, inside of the mesh.
  };
  std::size_t removed = 0;        ///< Tetrahedra beyond the planes, or in part.
  std::vector<Opening> openings;  ///< That the cuts made.
  std::vector<std::string> gone;  ///< Names of patches that lay beyond.
};

/// Cuts a mesh off by planes through everything, one after the other: what lies on a normal's side goes, as
/// cut_off_beyond() has it. The only opening in place of the only one that goes is called as that was; others
/// get the first names of "inlet_1", "outlet_1", … that are free, by
/// falling area, with the label behind where they are of several, and "wall_rim_1", … where a label surrounds
/// another; patches without faces leave the list.
/// @throws Error{kBadInput} as cut_off_beyond().
[[nodiscard]] CutMesh cut_mesh(MixedMesh& mesh, std::span<const CutPlane> planes);

}  // namespace lumesh
