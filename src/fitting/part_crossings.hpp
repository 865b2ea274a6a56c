#pragma once
// Counts where the outer surface of a part crosses itself or the surface around the part.

#include <cstdint>
#include <vector>

#include "mesh_part.hpp"

namespace lumesh::fitting {

/// The outer surface around a part of the mesh: it stays while the part changes.
class SurroundingSurface {
 public:
  /// @param tree  Has all triangles that the part may reach.
  SurroundingSurface(const WholeMesh& whole, const BoundaryTree& tree, const MeshPart& part,
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
