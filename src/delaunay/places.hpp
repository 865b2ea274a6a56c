#pragma once
/// @file Orders of tetrahedra by the places of their corners: numbers depend on who made what, places do not.

#include <algorithm>
#include <array>

#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

using CornerPlaces = std::array<Vec3, 4>;

/// Places of the corners, sorted by precedes().
[[nodiscard]] inline CornerPlaces corner_places(const TetMesh& mesh, TetId t) {
  CornerPlaces corners = {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3)};
  std::ranges::sort(corners, precedes);
  return corners;
}

/// A total order of tetrahedra: no two have the same corners.
[[nodiscard]] inline bool is_earlier(const CornerPlaces& a, const CornerPlaces& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), precedes);
}

}  // namespace lumesh::delaunay
