#pragma once
/// @file Estimated size of a mesh, before it is made.

#include "spacing.hpp"

namespace lumesh::delaunay {

/// Number of tetrahedra, from a coarse grid of samples: within a factor of two where parts are not thin.
[[nodiscard]] double estimated_tets(const Spacing& spacing);

/// @throws Error{kMemory} if that many tetrahedra would not fit, with the remedy.
void check_memory(const Spacing& spacing);

}  // namespace lumesh::delaunay
