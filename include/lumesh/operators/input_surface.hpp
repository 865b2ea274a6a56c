#pragma once
/// @file The patches of a mesh as they once were, for vertices that move along them.

#include <vector>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Threads: queries may run at the same time.
class InputSurface {
 public:
  /// Copies the faces of all patches. Cost as that of TriangleTree.
  explicit InputSurface(const TetMesh& mesh);

  /// Nearest point of a patch to `point` within `bound`; TriangleTree::kNone if there is none.
  [[nodiscard]] TriangleTree::Nearest nearest(PatchId patch, const Vec3& point, double bound) const {
    return trees_[patch.value].nearest(point, bound);
  }

 private:
  std::vector<TriangleTree> trees_;  // One per patch.
};

}  // namespace lumesh::operators
