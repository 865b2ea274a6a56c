#include <algorithm>
#include <array>

#include "scratch.hpp"

namespace lumesh::operators {

template <class Lock>
Outcome Operators<Lock>::swap_face(TetId t, int face, const SwapRules& rules) {
  return on_held(counts_.face_swap, subject_.mesh.vertex(t, 0), subject_.mesh.vertex(t, 1),
                 [&] { return swap_held_face(t, face, rules); });
}

template <class Lock>
Outcome Operators<Lock>::swap_held_face(TetId t, int face, const SwapRules& rules) {
  TetMesh& mesh = subject_.mesh;
  if (!try_hold(t)) return Outcome::kContended;
  const FaceLink link = mesh.link(t, face);
  if (link.is_boundary() || mesh.interface_patch(t, face).valid()) return Outcome::kRejected;
  const TetId n = link.tet();
  const VertexId below = mesh.vertex(t, face), above = mesh.vertex(n, link.face());
  if (!lock_.try_lock(above)) return Outcome::kContended;

  const Cell<3> rim = mesh.face_corners(t, face);  // Anticlockwise seen from `above`.
  const double least = std::min(mesh.quality(t), mesh.quality(n)) + rules.least_gain;
  std::array<double, 3> cubed{};
  for (int k = 0; k < 3; ++k) {
    const VertexId p(rim[k]), q(rim[(k + 1) % 3]);
    cubed[k] = quality_cubed(subject_.measure, mesh, p, q, below, above);
    if (cubed[k] <= least * least * least ||
        orient3d(mesh.point(p), mesh.point(q), mesh.point(below), mesh.point(above)) <= 0)
      return Outcome::kRejected;
  }

  // What lies over the rim's edges, above and below: behind the faces opposite the third corner.
  std::array<FaceLink, 3> over, under;
  std::array<PatchId, 3> patch_over, patch_under;
  for (int k = 0; k < 3; ++k) {
    const VertexId opposite(rim[(k + 2) % 3]);
    const int in_n = mesh.index_of(n, opposite), in_t = mesh.index_of(t, opposite);
    over[k] = mesh.link(n, in_n), patch_over[k] = mesh.interface_patch(n, in_n);
    under[k] = mesh.link(t, in_t), patch_under[k] = mesh.interface_patch(t, in_t);
  }
  const Label label = mesh.label(t);
  Builder& builder = scratch_->builder;
  builder.free_tet(t);
  builder.free_tet(n);
  std::array<TetId, 3> made;
  for (int k = 0; k < 3; ++k) {
    made[k] = builder.add_tet({rim[k], rim[(k + 1) % 3], below.value, above.value}, label);
    mesh.set_quality(made[k], static_cast<float>(metric::cube_root(cubed[k])));
    link_to(mesh, made[k], 2, over[k]);
    link_to(mesh, made[k], 3, under[k]);
    if (patch_over[k].valid()) mesh.set_interface_patch(made[k], 2, patch_over[k]);
    if (patch_under[k].valid()) mesh.set_interface_patch(made[k], 3, patch_under[k]);
    for (const std::uint32_t v : mesh.tet(made[k])) mesh.set_incident_tet(VertexId(v), made[k]);
  }
  for (int k = 0; k < 3; ++k) link_to(mesh, made[k], 0, FaceLink::to(made[(k + 1) % 3], 1));
  return Outcome::kApplied;
}

template Outcome Operators<NoLock>::swap_face(TetId, int, const SwapRules&);
template Outcome Operators<OrderedLock>::swap_face(TetId, int, const SwapRules&);
template Outcome Operators<SpeculativeLock>::swap_face(TetId, int, const SwapRules&);

}  // namespace lumesh::operators
