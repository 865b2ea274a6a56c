#pragma once
// The faces between materials and what binds each vertex.

#include <vector>

#include "lumesh/domain/patch_names.hpp"
#include "work_mesh.hpp"

namespace lumesh {

/// What the fit needs to know of the boundary.
struct BoundaryModel {
  std::vector<BoundaryTriangle> triangles;
  std::vector<MaterialSet> sets;  ///< Per vertex: materials that meet there; fewer than two inside.
};

/// Whether a vertex of this set lies in a cut plane; of its materials, cuts are the last.
[[nodiscard]] inline bool is_on_cut(const ImageDomain& domain, const MaterialSet& set) {
  return set.size() >= 2 && domain.is_cut(set[set.size() - 1]);
}

/// Reads the model off a mesh that still has the ring of tetrahedra outside.
[[nodiscard]] BoundaryModel find_boundary(const WorkMesh& mesh, const ImageDomain& domain);

/// Drops tetrahedra that `keep` refuses, and renumbers both mesh and model; triangles must not lose a vertex.
/// @return The vertices that are left, by their old numbers, ascending; those are their new order.
std::vector<std::uint32_t> drop_tetrahedra(WorkMesh& mesh, BoundaryModel& boundary,
                                           const std::vector<std::uint8_t>& keep);

}  // namespace lumesh
