#pragma once
/// @file Labels that keep their volumes while surfaces are adapted.

#include <map>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh {

/// Where coarse triangles stand for a bent surface in another way than those of the first mesh did, labels
/// are larger or smaller by a few thousandths. Moves all vertices inside patches that keep their volume along
/// their normals, of each patch by the same distance, until no label has changed by more than 0.05 %, as far
/// as tetrahedra let them: the distances with the least sum of squares over the area.
/// @param wanted  Volumes of the labels, in mm^3. @param place  Of patches that keep their volume.
/// @param rules   may_become and keep_within are kept to. @param mesh  Compact; where anything moves, its
/// qualities are measured before, which may_become may ask for.
/// Parallel inside, the same for every thread count.
void restore_volumes(TetMesh& mesh, const std::map<Label, double>& wanted,
                     const operators::PlaceOnPatch& place, const operators::SettlingRules& rules);

}  // namespace lumesh
