#pragma once
// Keeps the outer surface from crossing itself.

#include <cstdint>
#include <span>
#include <vector>

#include "fit_setting.hpp"
#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

class BoundaryTree;

/// The triangles of the outside of the mesh.
[[nodiscard]] std::vector<Triangle> outer_triangles(const BoundaryModel& boundary, const ImageDomain& domain);

/// Puts vertices back to earlier places wherever the outer surface crosses or touches itself
/// (operators/crossings.hpp).
/// @param before_mm  Places of the first vertices that are known to be good; others stay.
void undo_crossings(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                    const std::vector<Vec3>& before_mm, const AngleLimits& limits);

/// Whether the outer surface crosses or touches itself at some triangles.
/// @param tree  Of all triangles, since when no vertex has moved by more than `moved_mm`.
[[nodiscard]] bool crosses_at(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                              const BoundaryTree& tree, double moved_mm,
                              std::span<const std::uint32_t> triangles);

}  // namespace lumesh::fitting
