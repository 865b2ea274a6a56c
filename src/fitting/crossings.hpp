#pragma once
// Keeps the outer surface from crossing itself.

#include <vector>

#include "mesh_part.hpp"

namespace lumesh::fitting {

/// Puts vertices back to earlier places wherever the outer surface crosses or touches itself
/// (operators/crossings.hpp).
/// @param before_mm  Places of the first vertices that are known to be good; others stay.
void undo_crossings(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                    const std::vector<Vec3>& before_mm, const AngleLimits& limits);

/// Whether the outer surface crosses or touches itself at some triangles.
/// @param tree  Of all triangles, since when no vertex has moved by more than `moved_mm`.
[[nodiscard]] bool crosses_at(const WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                              const SurfaceTree& tree, double moved_mm,
                              std::span<const std::uint32_t> triangles);

/// The outer surface around a part of the mesh: it stays while the part changes.
class OuterSurroundings {
 public:
  /// @param tree  Has all triangles that the part may reach.
  OuterSurroundings(const WholeMesh& whole, const SurfaceTree& tree, const MeshPart& part,
                    const ImageDomain& domain);

  /// Pairs of triangles that cross or touch, of the part as it is now and of what is around it.
  [[nodiscard]] std::size_t count_crossings(const MeshPart& part) const;

 private:
  const ImageDomain& domain_;
  std::size_t known_;             // Vertices that the part shared with the whole mesh at first.
  std::vector<Triangle> around_;  // Triangles; corners by the part's numbers, then those of others_mm_.
  std::vector<Vec3> others_mm_;
};

}  // namespace lumesh::fitting
