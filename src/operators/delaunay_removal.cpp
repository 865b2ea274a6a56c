#include <algorithm>

#include "delaunay_scratch.hpp"
#include "links.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"
#include "soundness.hpp"

namespace lumesh::operators {
namespace {

/// Key of a face by its corners in any order; places below 2^21.
std::uint64_t face_key(Cell<3> corners) {
  std::ranges::sort(corners);
  return std::uint64_t{corners[0]} << 42 | std::uint64_t{corners[1]} << 21 | corners[2];
}

}  // namespace

/// The tetrahedra around v into conflicts, the faces opposite v into hull, its neighbours into around; all
/// held.
template <class Lock>
bool DelaunayKernel<Lock>::gather_star(VertexId v) {
  auto& conflicts = scratch_->conflicts;
  auto& hull = scratch_->hull;
  auto& around = scratch_->around;
  auto& places = scratch_->places;
  auto& known = scratch_->open_by_corners;
  const TetMesh& mesh = *mesh_;
  conflicts.clear();
  hull.clear();
  around.clear();
  places.clear();
  known.clear();
  const auto take_in = [&](TetId t) {
    if (known.insert(t.value, 0).added) conflicts.push_back({t, 0});
  };
  take_in(mesh.incident_tet(v));
  for (std::size_t next = 0; next < conflicts.size(); ++next) {
    const TetId t = conflicts[next].tet;
    if (!hold_tet(t)) return false;
    const int own = mesh.index_of(t, v);
    for (int f = 0; f < 4; ++f)
      if (f != own) take_in(mesh.link(t, f).tet());
    const Cell<3> corners = mesh.face_corners(t, own);
    hull.push_back({{corners[0], corners[2], corners[1]}, mesh.link(t, own), {}, {}});
    for (std::size_t i = 0; i < 3; ++i) {
      hull.back().places[i] =
          places.insert(hull.back().corners[i], static_cast<std::uint32_t>(around.size())).value;
      if (hull.back().places[i] == around.size()) around.push_back(VertexId(hull.back().corners[i]));
    }
  }
  return true;
}

/// Fills the hole from its faces inwards: on each open face stands the one tetrahedron whose circumsphere
/// holds none of the vertices around.
template <class Lock>
void DelaunayKernel<Lock>::wrap_hole() {
  auto& hull = scratch_->hull;
  auto& around = scratch_->around;
  auto& open = scratch_->open;
  auto& wrapped = scratch_->wrapped;
  auto& open_by_corners = scratch_->open_by_corners;
  const auto point = [&](std::uint32_t place) -> const Vec3& { return mesh_->point(around[place]); };
  open.clear();
  wrapped.clear();
  open_by_corners.clear();
  constexpr std::uint32_t kClosed = ~0u;
  const auto add_open = [&](const DelaunayScratch::OpenFace& face) {
    const auto [at, added] =
        open_by_corners.insert(face_key(face.corners), static_cast<std::uint32_t>(open.size()));
    LUMESH_ASSERT(added || at == kClosed);
    at = static_cast<std::uint32_t>(open.size());
    open.push_back(face);
  };
  const auto join = [&](std::uint32_t tet, std::size_t f, const DelaunayScratch::OpenFace& other) {
    wrapped[tet].behind[f] = other.tet;
    wrapped[tet].behind_face[f] = other.face;
    if ((other.tet & DelaunayScratch::kHull) != 0) return;
    wrapped[other.tet].behind[static_cast<std::size_t>(other.face)] = tet;
    wrapped[other.tet].behind_face[static_cast<std::size_t>(other.face)] = static_cast<int>(f);
  };
  for (std::uint32_t i = 0; i < hull.size(); ++i) add_open({hull[i].places, DelaunayScratch::kHull | i, 0});
  for (std::size_t next = 0; next < open.size(); ++next) {
    const DelaunayScratch::OpenFace face = open[next];
    std::uint32_t& state = *open_by_corners.find(face_key(face.corners));
    if (state != next) continue;  // Closed from the other side.
    state = kClosed;
    const auto [a, b, c] = face.corners;
    std::uint32_t apex = kClosed;
    for (std::uint32_t w = 0; w < around.size(); ++w) {
      if (w == a || w == b || w == c || orient3d(point(a), point(b), point(c), point(w)) <= 0) continue;
      if (apex == kClosed || insphere_perturbed(point(a), point(b), point(c), point(apex), point(w)))
        apex = w;
    }
    LUMESH_ASSERT(apex != kClosed);
    const auto tet = static_cast<std::uint32_t>(wrapped.size());
    wrapped.push_back({{a, b, c, apex}, {}, {}});
    join(tet, 3, face);
    for (std::size_t f = 0; f < 3; ++f) {
      const auto& [i, j, k] = kTetFaces[f];
      const Cell<4>& v = wrapped[tet].corners;
      const Cell<3> outwards = {v[static_cast<std::size_t>(i)], v[static_cast<std::size_t>(j)],
                                v[static_cast<std::size_t>(k)]};
      std::uint32_t* const other = open_by_corners.find(face_key(outwards));
      if (other == nullptr || *other == kClosed) {
        add_open({outwards, tet, static_cast<int>(f)});
        continue;
      }
      join(tet, f, open[*other]);
      *other = kClosed;
    }
  }
}

template <class Lock>
void DelaunayKernel<Lock>::replace_star(VertexId v) {
  auto& conflicts = scratch_->conflicts;
  auto& hull = scratch_->hull;
  auto& around = scratch_->around;
  auto& wrapped = scratch_->wrapped;
  auto& made = scratch_->made;
  TetMesh& mesh = *mesh_;
  made.clear();
  for (const auto& tet : wrapped) {
    const auto [a, b, c, d] = tet.corners;
    made.push_back(
        make_tet({around[a].value, around[b].value, around[c].value, around[d].value}, made.size()));
    for (const std::uint32_t corner : tet.corners) mesh.set_incident_tet(around[corner], made.back());
  }
  for (std::size_t i = made.size(); i < conflicts.size(); ++i) mesh.free_tet(conflicts[i].tet, owner_);
  mesh.free_vertex(v, owner_);
  for (std::size_t i = 0; i < wrapped.size(); ++i) {
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint32_t behind = wrapped[i].behind[f];
      if ((behind & DelaunayScratch::kHull) != 0)
        link_to(mesh, made[i], static_cast<int>(f), hull[behind & ~DelaunayScratch::kHull].behind);
      else
        mesh.set_link(made[i], static_cast<int>(f), FaceLink::to(made[behind], wrapped[i].behind_face[f]));
    }
  }
  LUMESH_PARANOID_ASSERT(are_sound(mesh, made));
}

template <class Lock>
Outcome DelaunayKernel<Lock>::remove(VertexId v) {
  Outcome outcome = Outcome::kContended;
  if (lock_.try_lock(v) && gather_star(v)) {
    wrap_hole();
    replace_star(v);
    outcome = Outcome::kApplied;
  }
  lock_.release_to(0);
  return outcome;
}

template class DelaunayKernel<NoLock>;
template class DelaunayKernel<SpeculativeLock>;

}  // namespace lumesh::operators
