#include <algorithm>

#include "scratch.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

/// True if t can be taken away with two of its faces on the outside, those without c or without d, so that
/// the surface stays a manifold: the edge (c, d), which comes to light, lay in the volume until now.
bool leaves_manifold(const TetMesh& mesh, TetId t, VertexId a, VertexId b, const EdgeRing& ring_of_cd) {
  const auto may_come_to_light = [&](VertexId opposite) {
    const int face = mesh.index_of(t, opposite);
    return !mesh.link(t, face).is_boundary() && !mesh.interface_patch(t, face).valid();
  };
  return may_come_to_light(a) && may_come_to_light(b) && ring_of_cd.patch_faces == 0;
}

}  // namespace

template <class Lock>
Outcome Operators<Lock>::remove_held_boundary_sliver(TetId t, VertexId a, VertexId b) {
  TetMesh& mesh = subject_.mesh;
  EdgeRing& ring = scratch_->ring;
  const PatchId patch = ring.patches[0];
  const VertexId c(ring.rim[0]), d(ring.rim[1]);
  if (!keeps_to_surface_across(mesh, ring, a, b, subject_.shapes)) return Outcome::kRejected;
  if (!gather_ring(mesh, t, c, d, lock_, ring)) return Outcome::kContended;
  if (!leaves_manifold(mesh, t, a, b, ring)) return Outcome::kRejected;

  for (const VertexId opposite : {a, b}) {
    const FaceLink behind = mesh.link(t, mesh.index_of(t, opposite));
    mesh.set_link(behind.tet(), behind.face(), FaceLink::boundary(patch));
    for (const std::uint32_t v : mesh.face_corners(behind.tet(), behind.face()))
      mesh.set_incident_tet(VertexId(v), behind.tet());
  }
  scratch_->builder.note_change(mesh.tet(t));
  scratch_->builder.free_tet(t);
  return Outcome::kApplied;
}

template Outcome Operators<NoLock>::remove_held_boundary_sliver(TetId, VertexId, VertexId);
template Outcome Operators<OrderedLock>::remove_held_boundary_sliver(TetId, VertexId, VertexId);
template Outcome Operators<SpeculativeLock>::remove_held_boundary_sliver(TetId, VertexId, VertexId);

}  // namespace lumesh::operators
