#pragma once
/// @file Keeps the outside of a mesh from crossing itself. Tetrahedra that stay positive one by one can still
/// reach through the gap between two sheets of the surface, or close a cleft until its walls change places.

#include <cstddef>
#include <span>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh::operators {

struct UndoReport {
  std::size_t put_back = 0;   ///< Vertices put back.
  std::size_t crossings = 0;  ///< Pairs of faces that still cross, because they did so before.
};

/// Puts vertices back to earlier places wherever the outside crosses or touches itself, and as many around
/// them as tetrahedra need to stay positive and as `may_become` allows, compared with their earlier shapes.
/// @param points  Places of all vertices that the cells name, now.
/// @param outside  The faces that only one cell has.
/// @param before  Places of the first vertices that are known to be good; the others stay.
/// Parallel inside; bitwise identical for every thread count. Cost: about 1 us per face of the outside.
UndoReport undo_crossings(std::span<Vec3> points, std::span<const Cell<4>> tets,
                          std::span<const Cell<3>> outside, std::span<const Vec3> before,
                          const MayBecome& may_become);

/// The faces that only one cell has.
[[nodiscard]] std::vector<Cell<3>> outside_of(const BoundaryFaces& faces);

/// Moves the sheets that cross or touch apart, each into its own cells: their vertices move towards the
/// middle of the vertices around, step by step, as far as tetrahedra stay positive. Vertices of planes move
/// within them, those of curves and corners stay; where that does not do, both move freely, but those of
/// openings and planes of symmetry. Those of frozen patches stay.
/// @param mesh  Compact.
/// @param shapes  Shapes of the mesh's patches.
/// @return The pairs of faces that still cross.
std::size_t draw_apart(TetMesh& mesh, const PatchShapes& shapes);

}  // namespace lumesh::operators
