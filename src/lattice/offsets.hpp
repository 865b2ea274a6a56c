#pragma once
// How far beside the image's boundary the vertices shall lie, so that flat triangles between them keep the
// labels' volumes.

#include <map>
#include <utility>
#include <vector>

#include "boundary_model.hpp"

namespace lumesh {

/// Per vertex, in mm along the gradient of the separation of its (two) materials: the mean sag of the
/// triangles around it. Flat triangles between vertices on a curved surface cut its bulges off; this shift
/// keeps the volume and halves the largest distance.
[[nodiscard]] std::vector<double> sag_offsets_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                 const ImageDomain& domain);

/// Even shifts of the boundaries between two materials, the lower first, towards the second, in mm.
using Shifts = std::map<std::pair<Material, Material>, double>;

/// Those by which the labels would fill what their voxels fill.
/// @param label_volumes_mm3  Per material.
[[nodiscard]] Shifts volume_shifts_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const ImageDomain& domain,
                                      const std::vector<double>& label_volumes_mm3);

/// Adds an even shift of each boundary between two materials, so that the labels fill what their voxels fill:
/// undoes the little that smoothing takes away. The shifts solve "missing volume = area times shift, summed
/// over a label's boundaries" label by label until they settle.
/// @param label_volumes_mm3  Per material.
void add_volume_offsets(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                        const std::vector<double>& label_volumes_mm3, std::vector<double>& offsets_mm);

}  // namespace lumesh
