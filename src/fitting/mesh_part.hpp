#pragma once
// A part of the mesh with its own numbers, which may change by itself and be put back.

#include <cstdint>
#include <vector>

#include "fit_setting.hpp"
#include "lumesh/fitting/boundary_model.hpp"
#include "vertex_blocks.hpp"

namespace lumesh::fitting {

class BoundaryTree;

struct MeshPart {
  WorkMesh mesh;  ///< Without neighbours.
  BoundaryModel boundary;
  VertexTargets targets;
  std::vector<Vec3> lattice_mm;     ///< Places of the first vertices in the lattice.
  std::vector<std::uint8_t> fixed;  ///< Flag per vertex: tetrahedra outside the part share it.
  /// The numbers in the whole mesh; those of the part begin with these, in the same order.
  std::vector<std::uint32_t> vertices, tets, triangles;

  /// All vertices that may move, also new ones, in one block.
  [[nodiscard]] VertexBlocks movable() const;
};

/// The mesh as a whole, while parts of it change.
struct WholeMesh {
  WorkMesh& mesh;
  BoundaryModel& boundary;
  VertexTargets& targets;
  std::vector<Vec3> lattice_mm;               ///< Places of the vertices before the fit.
  std::vector<std::uint32_t> gone;            ///< Removed tetrahedra, which keep their number.
  std::vector<std::uint32_t> gone_triangles;  ///< Removed boundary triangles, which keep theirs.
};

/// The tetrahedra at the vertices within a radius that are connected to a boundary there, and the boundary
/// triangles with such a vertex.
/// @param tree  Has the triangles with a vertex within the radius.
[[nodiscard]] MeshPart cut_out(const WholeMesh& whole, const BoundaryTree& tree, const Vec3& centre_mm,
                               double radius_mm);

/// Puts a part back; the stars become void.
void put_back(WholeMesh& whole, const MeshPart& part);

/// Drops the boundary triangles that are gone; others get their numbers.
void drop_gone_triangles(WholeMesh& whole);
/// Fills the stars, without the tetrahedra that are gone.
void renew_stars(WholeMesh& whole);
/// Drops the tetrahedra that are gone and the vertices that have none; the stars and targets become void.
void drop_gone(WholeMesh& whole);

}  // namespace lumesh::fitting
