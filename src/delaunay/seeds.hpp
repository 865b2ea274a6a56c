#pragma once
/// @file Points to begin with: of a graded body-centred cubic lattice inside, and on boundaries near it.

#include <vector>

#include "spacing.hpp"

namespace lumesh::delaunay {

/// A point that may become one of a boundary.
struct BoundaryCandidate {
  Vec3 point;
  MaterialSet
      materials;   ///< Materials that meet there: two on a surface, three on a curve, more in a corner.
  double spacing;  ///< Wanted distance to other points of the same materials.
  bool is_fixed = false;  ///< Of Domain::fixed_points(): comes before others, and does not move.
};

struct Seeds {
  std::vector<Vec3> inner;
  std::vector<Vec3> outer;  ///< Coarser, so that no tetrahedron outside reaches past many of the boundary.
  std::vector<BoundaryCandidate> crowded;   ///< Points inside that stand too close; `inner` has what is left.
  std::vector<BoundaryCandidate> boundary;  ///< Several candidates for each point that is needed.
};

/// Parallel inside, the same for every thread count.
[[nodiscard]] Seeds lattice_seeds(const Spacing& spacing);

}  // namespace lumesh::delaunay
