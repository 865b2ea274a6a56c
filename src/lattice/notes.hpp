#pragma once
// What the user is told of a lattice mesh that is less than perfect.

#include <vector>

#include "lumesh/fitting/fit.hpp"
#include "lumesh/fitting/work_mesh.hpp"
#include "lumesh/lattice/lattice.hpp"

namespace lumesh {

/// Labels that have voxels, but no tetrahedron.
/// @param voxels  Number of kept voxels of each material.
[[nodiscard]] std::vector<Label> lost_labels(const fitting::WorkMesh& mesh, const ImageDomain& domain,
                                             const std::vector<double>& voxels);

/// Enters lost labels and deviations into the report, with a note for each kind of shortcoming.
void add_shortcomings(const fitting::WorkMesh& mesh, const fitting::FitReport& fit, const ImageDomain& domain,
                      const LatticeOptions& options, const std::vector<double>& voxels,
                      LatticeReport& report);

}  // namespace lumesh
