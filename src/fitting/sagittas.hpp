#pragma once
// How far beside the image's boundary the vertices shall lie, so that flat triangles between them keep the
// labels' volumes.

#include <map>
#include <utility>
#include <vector>

#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Per vertex, in mm along the gradient of the separation of its (two) materials: the mean sagitta of the
/// triangles around it. Flat triangles between vertices on a curved surface cut its bulges off; this shift
/// keeps the volume and halves the largest distance.
[[nodiscard]] std::vector<double> sagitta_offsets_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                     const ImageDomain& domain);

/// Even shifts of the boundaries between two materials, the lower first, towards the second, in mm.
using Shifts = std::map<std::pair<Material, Material>, double>;

/// Shifts by which the triangles would lie as much on one side of the domain's boundary as on the other, so
/// that labels have the volume that this boundary encloses.
[[nodiscard]] Shifts mean_sagittas_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const ImageDomain& domain);

}  // namespace lumesh::fitting
