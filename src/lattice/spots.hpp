#pragma once
// Mends the places where the surface and the domain's boundary are still too far apart, one by one.

#include "mesh_part.hpp"
#include "misses.hpp"

namespace lumesh {

/// At each spot, tetrahedra are added or change sides (missed_tips.hpp), then vertices are drawn to what is
/// missed, in turns; the best state stays. A long tip grows by one tetrahedron in each turn. What this does
/// not mend is tried again from the vertices' places in the lattice, where nothing is folded, shaken
/// in a different way each time. Spots far enough apart are mended at the same time, each in a part of the
/// mesh by itself.
/// @param whole  Has the vertices' places in the lattice.
/// @param probes  How many the finder has: where more than a hundredth of them (and more than 100) are
///                missed, the lattice is too coarse for this and nothing more is done.
/// @return What is missed at the end, the furthest first; only probes where the lattice is too coarse.
std::vector<Miss> mend_spots(WholeMesh& whole, const FitSetting& setting, MissFinder& finder,
                             std::size_t probes);

}  // namespace lumesh
