#pragma once
/// @file The faults of a mesh that no simulation survives, found quickly: what commands ask of meshes they
/// make.

#include <optional>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

/// A kind of fault in one readable line, with how often and a place.
struct MeshFault {
  std::string text;
  std::optional<Vec3> place = {};  ///< Place of the fault, where there is one; finite.
};

/// One fault of each kind; empty if there is none:
/// - cells that are not positive: tetrahedra by the exact predicate, others by their volume and Jacobians;
/// - faces with more than two cells;
/// - edges of the outside (the faces that only one cell has) without one face on each side;
/// - an outside that crosses or touches itself, by exact predicates, or pieces that lie within others;
/// - cells that together fill another volume than the outside encloses.
///
/// Without these the cells fill the space within the outside once. What is not looked at: patches, labels'
/// own surfaces; see validate(). Quadrilaterals count as two triangles.
///
/// Threads: parallel inside, the same lines for every thread count. Cost: about 0.3 s per million cells, 1 us
/// per face of the outside.
[[nodiscard]] std::vector<MeshFault> find_placed_faults(const MeshView& mesh);

/// Their lines alone.
[[nodiscard]] std::vector<std::string> find_faults(const MeshView& mesh);

}  // namespace lumesh::quality
