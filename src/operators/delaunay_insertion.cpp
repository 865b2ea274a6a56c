#include <cmath>
#include <memory>

#include "delaunay_scratch.hpp"
#include "links.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"
#include "soundness.hpp"

namespace lumesh::operators {
namespace {

/// Stamp of a tetrahedron that is about to go; its vertices are all held.
constexpr std::uint32_t kInConflict = TetMesh::kDeadStamp - 1;

bool holds(const TetMesh& mesh, TetId t, const Vec3& point) {
  const Cell<4>& v = mesh.tet(t);
  return insphere_perturbed(mesh.point(VertexId(v[0])), mesh.point(VertexId(v[1])),
                            mesh.point(VertexId(v[2])), mesh.point(VertexId(v[3])), point);
}

}  // namespace

TetMesh triangulation_around(const Vec3& centre, double radius) {
  // The tetrahedron with the corners s (+-1, +-1, +-1) holds a ball of radius s / sqrt(3).
  const double s = 3 * std::sqrt(3.0) * radius;
  const std::array<Vec3, 4> points = {centre + s * Vec3(1, 1, 1), centre + s * Vec3(-1, -1, 1),
                                      centre + s * Vec3(-1, 1, -1), centre + s * Vec3(1, -1, -1)};
  Cell<4> corners = {0, 1, 2, 3};
  if (orient3d(points[0], points[1], points[2], points[3]) < 0) std::swap(corners[2], corners[3]);
  const std::array<Label, 1> labels = {kBackground};
  TetMesh mesh = TetMesh::build(points, std::span(&corners, 1), labels);
  for (std::uint32_t v = 0; v < 4; ++v) mesh.set_dimension(VertexId(v), VertexDimension::kCorner);
  return mesh;
}

template <class Lock>
DelaunayKernel<Lock>::DelaunayKernel(TetMesh& mesh, Lock lock, int owner)
    : mesh_(&mesh), lock_(std::move(lock)), owner_(owner), scratch_(std::make_unique<DelaunayScratch>()) {}
template <class Lock>
DelaunayKernel<Lock>::DelaunayKernel(DelaunayKernel&&) noexcept = default;
template <class Lock>
DelaunayKernel<Lock>::~DelaunayKernel() = default;

template <class Lock>
bool DelaunayKernel<Lock>::hold_tet(TetId t) {
  for (const std::uint32_t v : mesh_->tet(t))
    if (!lock_.try_lock(VertexId(v))) return false;
  return true;
}

/// A face of t with the point strictly behind it, or -1.
template <class Lock>
int DelaunayKernel<Lock>::face_towards(TetId t, const Vec3& point, int first) const {
  for (int i = 0; i < 4; ++i) {
    const int f = (first + i) & 3;
    const auto& corners = kTetFaces[f];
    if (orient3d(mesh_->corner(t, corners[0]), mesh_->corner(t, corners[1]), mesh_->corner(t, corners[2]),
                 point) > 0)
      return f;
  }
  return -1;
}

template <class Lock>
TetId DelaunayKernel<Lock>::locate(const Vec3& point, VertexId near) {
  constexpr std::size_t kMaxHeld = 64;
  if (!lock_.try_lock(near)) return {};
  TetId t = mesh_->incident_tet(near);
  for (int first = 0;; first = (first + 1) & 3) {  // Turning, so that no direction is preferred for long.
    if (!hold_tet(t)) return {};
    const int face = face_towards(t, point, first);
    if (face < 0) return t;
    LUMESH_DEBUG_ASSERT(!mesh_->link(t, face).is_boundary());
    // Others want to pass, too. This tetrahedron stays held: from one vertex of it the walk could begin again
    // at the other end of what it has crossed, and would then never reach a vertex of many tetrahedra.
    if (lock_.mark() >= kMaxHeld) lock_.keep_only(mesh_->tet(t));
    t = mesh_->link(t, face).tet();
  }
}

/// All tetrahedra whose circumsphere holds the point, which are connected, and the faces around them.
template <class Lock>
bool DelaunayKernel<Lock>::gather_conflicts(TetId first, const Vec3& point) {
  auto& conflicts = scratch_->conflicts;
  auto& hull = scratch_->hull;
  TetMesh& mesh = *mesh_;
  conflicts.clear();
  hull.clear();
  const auto take_in = [&](TetId t) {
    conflicts.push_back({t, mesh.stamp(t)});
    mesh.set_stamp(t, kInConflict);
  };
  take_in(first);
  for (std::size_t next = 0; next < conflicts.size(); ++next) {
    const TetId t = conflicts[next].tet;
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (!behind.is_boundary()) {
        const TetId other = behind.tet();
        if (mesh.stamp(other) == kInConflict)
          continue;  // By this thread, which holds the vertices of the face.
        if (holds(mesh, other, point)) {
          if (!lock_.try_lock(mesh.vertex(other, behind.face()))) return false;
          take_in(other);
          continue;
        }
      }
      const Cell<3> corners = mesh.face_corners(t, f);
      hull.push_back({{corners[0], corners[2], corners[1]}, behind, {}, {}});
    }
  }
  return true;
}

template <class Lock>
void DelaunayKernel<Lock>::restore_conflicts() {
  for (const auto& [t, stamp] : scratch_->conflicts) mesh_->set_stamp(t, stamp);
}

/// In the slot of the i-th of those that go, or in a new one.
template <class Lock>
TetId DelaunayKernel<Lock>::make_tet(const Cell<4>& corners, std::size_t i) {
  if (i >= scratch_->conflicts.size()) return mesh_->add_tet(corners, kBackground, owner_, stamp_);
  const TetId t = scratch_->conflicts[i].tet;
  mesh_->set_tet(t, corners);
  mesh_->set_label(t, kBackground);
  mesh_->set_stamp(t, stamp_);
  return t;
}

template <class Lock>
VertexId DelaunayKernel<Lock>::fill_hole(const Vec3& point, VertexDimension dimension) {
  auto& conflicts = scratch_->conflicts;
  auto& hull = scratch_->hull;
  auto& edges = scratch_->edges;
  TetMesh& mesh = *mesh_;
  // Each vertex of the hull gets a place; they are all held, and their stamps serve for nothing else.
  constexpr std::uint32_t kNoPlace = TetMesh::kDeadStamp - 1;
  for (const auto& face : hull)
    for (const std::uint32_t corner : face.corners) mesh.set_stamp(VertexId(corner), kNoPlace);
  std::uint32_t places = 0;
  for (auto& face : hull) {
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId corner(face.corners[i]);
      if (mesh.stamp(corner) == kNoPlace) mesh.set_stamp(corner, places++);
      face.places[i] = mesh.stamp(corner);
    }
  }
  edges.begin(places);
  const VertexId v = mesh.add_vertex(point, owner_, stamp_);
  lock_.take_ownership(v);
  mesh.set_dimension(v, dimension);
  for (std::uint32_t i = 0; i < hull.size(); ++i) {
    auto& face = hull[i];
    const auto [a, b, c] = face.corners;
    face.filled = make_tet({a, b, c, v.value}, i);
    link_to(mesh, face.filled, 3, face.behind);
    for (const std::uint32_t corner : face.corners) mesh.set_incident_tet(VertexId(corner), face.filled);
    for (std::size_t k = 0; k < 3; ++k)
      edges.set(face.places[k], face.places[(k + 1) % 3], i << 2 | static_cast<std::uint32_t>((k + 2) % 3));
  }
  for (std::size_t i = hull.size(); i < conflicts.size(); ++i) mesh.free_tet(conflicts[i].tet, owner_);
  for (const auto& face : hull) {
    for (std::size_t k = 0; k < 3; ++k) {  // The face opposite corner k has the edge of the other two.
      const std::uint32_t other = edges.get(face.places[(k + 2) % 3], face.places[(k + 1) % 3]);
      mesh.set_link(face.filled, static_cast<int>(k),
                    FaceLink::to(hull[other >> 2].filled, static_cast<int>(other & 3)));
    }
  }
  mesh.set_incident_tet(v, hull.front().filled);
  LUMESH_PARANOID_ASSERT(is_sound_around(mesh, v));
  return v;
}

template <class Lock>
auto DelaunayKernel<Lock>::insert(const Vec3& point, VertexDimension dimension, VertexId near) -> Insertion {
  const TetId t = locate(point, near);
  Insertion result;
  if (t.valid()) {
    for (const std::uint32_t v : mesh_->tet(t))
      if (mesh_->point(VertexId(v)) == point) result = {Outcome::kRejected, VertexId(v)};
    if (result.outcome == Outcome::kContended) {
      if (gather_conflicts(t, point))
        result = {Outcome::kApplied, fill_hole(point, dimension)};
      else
        restore_conflicts();
    }
  }
  lock_.release_to(0);
  return result;
}

template class DelaunayKernel<NoLock>;
template class DelaunayKernel<SpeculativeLock>;

}  // namespace lumesh::operators
