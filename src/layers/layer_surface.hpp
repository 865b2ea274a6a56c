#pragma once
/// @file The surface that layers grow on: its triangles, the star of each vertex, and its rim.

#include <cstdint>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "patch_selection.hpp"

namespace lumesh::layers {

/// An edge that only one triangle of the surface has, in that triangle's sense.
struct RimEdge {
  std::uint32_t a = 0, b = 0;
  std::int32_t patch = -1;  ///< Patch of the mesh's face on its other side.
};

/// Planes that a vertex of the rim may not leave; none elsewhere.
struct RimPlanes {
  int count = 0;
  std::array<Vec3, 2> normals = {Vec3::Zero(), Vec3::Zero()};  ///< Orthonormal.

  /// The part of a direction that lies in all of them; zero where they leave no direction.
  [[nodiscard]] Vec3 project(const Vec3& x) const;
  /// One more plane; beyond two, directions are none.
  void add(const Vec3& normal);
  void forbid() { count = 3; }
  [[nodiscard]] bool forbids() const { return count > 2; }
};

struct LayerSurface {
  std::vector<std::uint32_t>
      vertices;  ///< Vertices of the mesh, ascending; numbers below are indices in this.
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;  ///< Anticlockwise seen from where the layers grow.
  std::vector<std::int32_t> patches;
  std::vector<RimEdge> rim;
  std::vector<RimPlanes> planes;  ///< One per vertex.
  operators::PatchShapes
      shapes;  ///< Shapes of the mesh's patches: planes of the flat ones beside the layers.
  parallel::Adjacency triangles_around, neighbours;
  std::vector<Cell<3>> others;  ///< The other triangles of the mesh's outside, by vertices of the mesh.
};

/// The triangles of the patches chosen. @param is_inward  Layers grow into the mesh.
[[nodiscard]] LayerSurface surface_of(const TetMesh& mesh, const BoundaryFaces& faces,
                                      const PatchSelection& selection, bool is_inward);

}  // namespace lumesh::layers
