#pragma once
/// @file The tetrahedra around an edge and around a vertex, gathered under locks.

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "lumesh/core/local_map.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/terms.hpp"

namespace lumesh::operators {

/// By the exact predicate.
[[nodiscard]] inline bool is_positive(const TetMesh& mesh, TetId t) {
  return orient3d(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3)) > 0;
}

/// The corners of t besides i and j, ordered so that (i, j, first, second) is positively oriented.
[[nodiscard]] inline std::array<int, 2> other_corners(int i, int j) {
  std::array<int, 2> others{};
  for (int k = 0, n = 0; k < 4; ++k)
    if (k != i && k != j) others[n++] = k;
  // (i, j, first, second) must be an even permutation of (0, 1, 2, 3).
  const std::array<int, 4> order = {i, j, others[0], others[1]};
  int inversions = 0;
  for (int k = 0; k < 4; ++k)
    for (int m = k + 1; m < 4; ++m) inversions += order[k] > order[m] ? 1 : 0;
  if (inversions % 2 != 0) std::swap(others[0], others[1]);
  return others;
}

/// For lists of a few.
template <class Item>
void add_once(std::vector<Item>& items, const Item& item) {
  if (std::ranges::find(items, item) == items.end()) items.push_back(item);
}

/// The tetrahedra around edge (a, b) in the order of rotation: tets[k] is (a, b, rim[k], rim[k + 1]),
/// positively oriented; in a closed ring the rim goes round, in an open one it has one vertex more than there
/// are tetrahedra. The two ends of an open ring are faces of the outside.
struct EdgeRing {
  std::vector<TetId> tets;
  std::vector<std::uint32_t> rim;
  bool open = false;
  /// Patches of the faces at the edge, outside or interface, without repetition; and the number of such
  /// faces.
  std::vector<PatchId> patches;
  int patch_faces = 0;

  /// Dimension of a vertex put on the edge.
  [[nodiscard]] VertexDimension dimension() const {
    if (patch_faces == 0) return VertexDimension::kVolume;
    return patch_faces == 2 && patches.size() == 1 ? VertexDimension::kSurface : VertexDimension::kCurve;
  }
  void clear() {
    tets.clear();
    rim.clear();
    patches.clear();
    open = false;
    patch_faces = 0;
  }
  void add_patch(PatchId patch) {
    ++patch_faces;
    add_once(patches, patch);
  }
};

/// @return false if a vertex of the ring was not to be locked. The caller holds a and b.
template <class Lock>
bool gather_ring(const TetMesh& mesh, TetId start, VertexId a, VertexId b, Lock& lock, EdgeRing& ring) {
  ring.clear();
  const auto [first, second] = other_corners(mesh.index_of(start, a), mesh.index_of(start, b));
  const VertexId begin = mesh.vertex(start, first), end = mesh.vertex(start, second);
  if (!lock.try_lock(begin) || !lock.try_lock(end)) return false;
  ring.tets.push_back(start);
  ring.rim = {begin.value, end.value};
  // Turns around the edge: leaves each tetrahedron through the face opposite the rim vertex it was entered
  // by.
  enum class End { kClosed, kBoundary, kNotLocked };
  const auto turn = [&](VertexId behind, VertexId ahead, const auto& add) {
    for (TetId t = start;;) {
      const int face = mesh.index_of(t, behind);
      const FaceLink link = mesh.link(t, face);
      const PatchId patch = mesh.patch(t, face);
      if (patch.valid()) ring.add_patch(patch);
      if (link.is_boundary()) return End::kBoundary;
      if (link.tet() == start) return End::kClosed;
      t = link.tet();
      const VertexId next = mesh.vertex(t, link.face());
      if (!lock.try_lock(next)) return End::kNotLocked;
      add(t, next);
      behind = std::exchange(ahead, next);
    }
  };
  const End forward = turn(begin, end, [&](TetId t, VertexId next) {
    ring.tets.push_back(t);
    ring.rim.push_back(next.value);
  });
  if (forward == End::kClosed) ring.rim.pop_back();  // The last one is the first one.
  if (forward != End::kBoundary) return forward == End::kClosed;
  ring.open = true;
  const std::size_t ahead_tets = ring.tets.size(), ahead_rim = ring.rim.size();
  const End backward = turn(end, begin, [&](TetId t, VertexId next) {
    ring.tets.push_back(t);
    ring.rim.push_back(next.value);
  });
  // What was met backwards goes to the front, the farthest first.
  const auto to_front = [](auto& items, std::size_t ahead) {
    std::reverse(items.begin() + static_cast<std::ptrdiff_t>(ahead), items.end());
    std::rotate(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(ahead), items.end());
  };
  to_front(ring.tets, ahead_tets);
  to_front(ring.rim, ahead_rim);
  return backward == End::kBoundary;
}

/// The tetrahedra around a vertex, with the vertices and patches there.
struct VertexBall {
  std::vector<TetId> tets;
  std::vector<std::uint32_t> neighbours;
  std::vector<PatchId> patches;  ///< Of faces at the vertex, without repetition.

  LocalMap<std::uint32_t, char> known_tets;
  LocalMap<std::uint32_t, std::uint32_t> places;  ///< In `neighbours`.
};

/// @return false if a vertex was not to be locked. The caller holds v.
template <class Lock>
bool gather_ball(const TetMesh& mesh, VertexId v, Lock& lock, VertexBall& ball) {
  ball.tets.assign(1, mesh.incident_tet(v));
  ball.neighbours.clear();
  ball.patches.clear();
  ball.known_tets.clear();
  ball.places.clear();
  ball.known_tets.insert(ball.tets[0].value, 0);
  const auto add_vertex = [&](std::uint32_t w) {
    if (!ball.places.insert(w, static_cast<std::uint32_t>(ball.neighbours.size())).added) return true;
    ball.neighbours.push_back(w);
    return lock.try_lock(VertexId(w));
  };
  for (const std::uint32_t w : mesh.tet(ball.tets[0]))
    if (w != v.value && !add_vertex(w)) return false;
  for (std::size_t next = 0; next < ball.tets.size(); ++next) {
    const TetId t = ball.tets[next];
    const int own = mesh.index_of(t, v);
    for (int i = 0; i < 4; ++i) {
      if (i == own) continue;
      const FaceLink link = mesh.link(t, i);
      if (const PatchId patch = mesh.patch(t, i); patch.valid()) add_once(ball.patches, patch);
      if (link.is_boundary() || !ball.known_tets.insert(link.tet().value, 0).added) continue;
      ball.tets.push_back(link.tet());
      if (!add_vertex(mesh.vertex(link.tet(), link.face()).value))
        return false;  // The others are known from t.
    }
  }
  return true;
}

enum class Joined : std::uint8_t { kNo, kYes, kNotLocked };

/// Whether an edge joins a and b already, which would be there twice if an operator made it. Only vertices of
/// boundaries are looked at: where the mesh is embedded no other ones can be, and not even those unless a
/// surface that moves has come to touch itself.
template <class Lock>
Joined are_joined(const TetMesh& mesh, VertexId a, VertexId b, Lock& lock, VertexBall& ball) {
  if (mesh.dimension(a) == VertexDimension::kVolume || mesh.dimension(b) == VertexDimension::kVolume)
    return Joined::kNo;
  if (!gather_ball(mesh, a, lock, ball)) return Joined::kNotLocked;
  const bool found = std::ranges::find(ball.neighbours, b.value) != ball.neighbours.end();
  return found ? Joined::kYes : Joined::kNo;
}

/// Outcome of an operator that must not make an edge twice; none if it may go on.
[[nodiscard]] inline std::optional<Outcome> refusal_of(Joined joined) {
  if (joined == Joined::kNo) return std::nullopt;
  return joined == Joined::kYes ? Outcome::kRejected : Outcome::kContended;
}

}  // namespace lumesh::operators
