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

/// Where t stands in the table, or would.
std::size_t ConflictFinder::slot_of(TetId t) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = (t.value * 0x9E3779B1u >> 7) & mask;
  while (table_[slot] != TetId::kNone && table_[slot] != t.value) slot = (slot + 1) & mask;
  return slot;
}

void ConflictFinder::take_in(TetId t) {
  table_[slot_of(t)] = t.value;
  tets_.push_back(t);
  if (4 * tets_.size() < table_.size()) return;
  table_.assign(4 * table_.size(), TetId::kNone);
  for (const TetId one : tets_) table_[slot_of(one)] = one.value;
}

std::span<const TetId> ConflictFinder::find(const TetMesh& mesh, const Vec3& point, TetId near) {
  constexpr std::size_t kSmall = 256;
  tets_.clear();
  table_.assign(kSmall, TetId::kNone);
  const TetId first = walk_to(mesh, point, near);
  if (!first.valid() || !holds(mesh, first, point)) return {};
  take_in(first);
  for (std::size_t next = 0; next < tets_.size(); ++next) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(tets_[next], f);
      if (behind.is_boundary() || table_[slot_of(behind.tet())] != TetId::kNone) continue;
      if (holds(mesh, behind.tet(), point)) take_in(behind.tet());
    }
  }
  return tets_;
}

}  // namespace lumesh::delaunay
