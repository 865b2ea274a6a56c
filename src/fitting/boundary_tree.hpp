#pragma once
// Finds triangles of the boundary near a place.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/geometry/triangle_tree.hpp"

namespace lumesh::fitting {

/// A reach that leaves out nothing that tetrahedra near boundaries could touch, whose edges are shorter as a
/// rule.
inline constexpr double kNearVoxels = 8;

/// A tree over boundary triangles as they lie when it is made.
class BoundaryTree {
 public:
  static constexpr std::uint32_t kNone = TriangleTree::kNone;
  struct Nearest {
    double distance_mm;
    std::uint32_t triangle;  // kNone if there are no triangles
  };

  /// Over all triangles.
  BoundaryTree(const WorkMesh& mesh, const BoundaryModel& boundary);
  /// Over the triangles whose centres are within `reach_mm` of any of the places, and some more.
  BoundaryTree(const WorkMesh& mesh, const BoundaryModel& boundary, std::span<const Vec3> places,
               double reach_mm);

  [[nodiscard]] Nearest nearest(const Vec3& p) const;
  /// Triangles whose boxes meet [low, high], ascending.
  [[nodiscard]] std::vector<std::uint32_t> overlapping(const Vec3& low, const Vec3& high) const;

 private:
  std::vector<std::uint32_t> ids_;  // of the tree's triangles, ascending
  TriangleTree tree_;
};

}  // namespace lumesh::fitting
