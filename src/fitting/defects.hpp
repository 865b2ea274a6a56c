#pragma once
// Repair of defects: places where the surface and the domain's boundary are still too far apart, one by one.

#include <cstddef>
#include <vector>

#include "deviation_finder.hpp"
#include "mesh_part.hpp"

namespace lumesh::fitting {

/// At each defect, tetrahedra are added or change sides (protrusions.hpp), then vertices are attracted to the
/// deviating probes, in turns; the best state stays. A long protrusion grows by one tetrahedron in each turn.
/// A defect that this does not repair is tried again from the vertices' places in the lattice, where nothing
/// is folded, perturbed in a different way each time. Defects far enough apart are repaired at the same time,
/// each in a part of the mesh by itself.
/// @param whole  Has the vertices' places in the lattice.
/// @param probes  Number of probes that the finder has: where more than a hundredth of them (and more than
///                100) deviate, the lattice is too coarse for repairs and none are made.
/// @return Deviations that remain, the largest first; only those of probes where the lattice is too coarse.
std::vector<Deviation> repair_defects(WholeMesh& whole, const FitSetting& setting, DeviationFinder& finder,
                                      std::size_t probes);

}  // namespace lumesh::fitting
