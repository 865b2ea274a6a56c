#pragma once
/// @file The faults of a mesh that no simulation survives, found quickly: what every command asks of what it
/// wrote.

#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

/// One readable line per kind of fault, with how often and a place; empty if there is none:
/// - cells that are not positive: tetrahedra by the exact predicate, others by their volume and the Jacobians
/// at
///   their corners;
/// - edges of the outside (the faces of patches that are no interface) without one face on each side;
/// - an outside that crosses or touches itself, by exact predicates (quadrilaterals as two triangles);
/// - cells that together fill another volume than the outside encloses: gaps or overlaps within.
/// Together these say that the cells fill the space within the outside once. What is not looked at: links
/// between cells, patches, labels' own surfaces; see validate(). Threads: parallel inside, the same lines for
/// every thread count. Cost: about 0.1 s per million cells, 1 us per face of the outside.
[[nodiscard]] std::vector<std::string> find_faults(const MeshView& mesh);

}  // namespace lumesh::quality
