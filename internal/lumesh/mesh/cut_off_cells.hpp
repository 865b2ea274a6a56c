#pragma once
/// @file A mesh of tetrahedra cut off by a plane.

#include <cstddef>
#include <cstdint>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct CellsCutOff {
  std::size_t removed = 0;       ///< Tetrahedra of the given mesh that lie beyond, or in part.
  std::int32_t first_patch = 0;  ///< First of the new ones, which stand last.
  double farthest_moved_mm = 0;  ///< Way of a vertex into the plane.
};

/// Cuts off what lies beyond a plane.
///
/// Vertices within a quarter of the edges there move into the plane where no tetrahedron loses more than four
/// fifths of its volume: vertices of smooth walls along these, vertices on edges between patches not at all.
/// Then edges through the plane are divided at it, tetrahedra and patches with them, each by its edges in
/// ascending order, so that neighbours agree. What has a corner beyond goes. Faces that this bares are
/// patches of kind kOpening without a name, one for each connected piece of each label, by falling area;
/// those without use stay in the list. Points of the new ones lie in the plane but for rounding; metric and
/// wanted sizes are interpolated. What is left before the plane stays to the last bit, in its order.
///
/// @param mesh  Cells of other shapes may lie on one side of the plane, not touch it.
/// @param normal  Unit, towards what goes. Both in the mesh's own unit and frame.
/// @throws Error{kBadInput}, with the mesh as it was, if nothing is left, nothing lies beyond, a cell of
/// another shape is in the way, or a tetrahedron would be flat. Cost: about 1 us per tetrahedron.
CellsCutOff cut_off_beyond(MixedMesh& mesh, const Vec3& point, const Vec3& normal);

}  // namespace lumesh
