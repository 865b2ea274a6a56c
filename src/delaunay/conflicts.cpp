#include "conflicts.hpp"

#include "lumesh/geometry/perturbed_insphere.hpp"

namespace lumesh::delaunay {
namespace {

TetId walk_to(const TetMesh& mesh, const Vec3& point, TetId t) {
  for (int first = 0;; first = (first + 1) & 3) {
    int face = -1;
    for (int i = 0; i < 4 && face < 0; ++i) {
      const int f = (first + i) & 3;
      const auto& [a, b, c] = kTetFaces[f];
      if (orient3d(mesh.corner(t, a), mesh.corner(t, b), mesh.corner(t, c), point) > 0) face = f;
    }
    if (face < 0) return t;
    const FaceLink behind = mesh.link(t, face);
    if (behind.is_boundary()) return {};
    t = behind.tet();
  }
}

bool holds(const TetMesh& mesh, TetId t, const Vec3& point) {
  for (int i = 0; i < 4; ++i)
    if (mesh.corner(t, i) == point) return false;
  return insphere_perturbed(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3),
                            point);
}

}  // namespace

std::span<const TetId> ConflictFinder::find(const TetMesh& mesh, const Vec3& point, TetId near) {
  tets_.clear();
  known_.clear();
  const auto take_in_if_it_holds = [&](TetId t) {
    if (known_.contains(t.value) || !holds(mesh, t, point)) return;
    known_.insert(t.value, 0);
    tets_.push_back(t);
  };
  const TetId first = walk_to(mesh, point, near);
  if (first.valid()) take_in_if_it_holds(first);
  for (std::size_t next = 0; next < tets_.size(); ++next) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(tets_[next], f);
      if (!behind.is_boundary()) take_in_if_it_holds(behind.tet());
    }
  }
  return tets_;
}

}  // namespace lumesh::delaunay
