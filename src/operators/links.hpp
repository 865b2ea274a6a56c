#pragma once
/// @file Links from new tetrahedra to those around them.

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Makes t and what lies behind a face neighbours, or the face one of the outside.
inline void link_to(TetMesh& mesh, TetId t, int face, FaceLink behind) {
  mesh.set_link(t, face, behind);
  if (!behind.is_boundary()) mesh.set_link(behind.tet(), behind.face(), FaceLink::to(t, face));
}

/// What lies behind a face of a tetrahedron that goes, for the one that comes in its place.
struct Side {
  FaceLink link;
  PatchId patch;
};
[[nodiscard]] inline Side side_of(const TetMesh& mesh, TetId t, int face) {
  return {mesh.link(t, face), mesh.patch(t, face)};
}
inline void put_behind(TetMesh& mesh, TetId t, int face, const Side& side) {
  link_to(mesh, t, face, side.link);
  if (side.patch.valid() && !side.link.is_boundary()) mesh.set_interface_patch(t, face, side.patch);
}

}  // namespace lumesh::operators
