#pragma once
/// @file The input patches of a mesh, for vertices that slide along them.

#include <vector>

#include "lumesh/domain/surface.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// Threads: queries may run at the same time.
class InputSurface {
 public:
  /// Copies the faces of all patches. Cost as that of TriangleTree.
  /// @param keep_within  Where smooth() may put a place; null: everywhere.
  explicit InputSurface(const TetMesh& mesh, KeepWithin keep_within = {});

  /// Nearest point of a patch to `point` within `bound`; TriangleTree::kNone if there is none.
  [[nodiscard]] TriangleTree::Nearest nearest(PatchId patch, const Vec3& point, double bound) const {
    return parts_[patch.value].tree.nearest(point, bound);
  }
  /// The place of the smooth surface through the patch's vertices over the nearest point of its faces; that
  /// point itself where the patch is flat, has a crease or ends, and where that place may not be.
  [[nodiscard]] Vec3 smooth(PatchId patch, const TriangleTree::Nearest& nearest) const;

 private:
  struct Part {
    TriangleTree tree;
    std::vector<Cell<3>> triangles;
    bool is_plane = false;
  };
  std::vector<Part> parts_;             // One per patch.
  std::vector<Vec3> points_, normals_;  // Points of the mesh's vertices and mean normals of the faces around.
  KeepWithin keep_within_;
};

}  // namespace lumesh::operators
