#include "bad_faces.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_set>

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/mesh_walks.hpp"

namespace lumesh::delaunay {
namespace {

struct Removal {
  double badness;  // Cosine of the smallest angle.
  VertexId vertex;
};

/// Which of two vertices may rather go: one of a surface before one of a curve; among equals, their places
/// decide.
bool may_rather_go(const TetMesh& mesh, VertexId v, VertexId w, bool first) {
  if (mesh.dimension(v) != mesh.dimension(w)) return mesh.dimension(v) > mesh.dimension(w);
  return precedes(mesh.point(v), mesh.point(w)) == first;
}

/// Vertices that may not go: fixed ones, and those of rims without which a rim would have edges longer than
/// it is to have.
class NeededVertices {
 public:
  NeededVertices(const TetMesh& mesh, const Spacing& spacing) : mesh_(mesh), spacing_(spacing) {}

  [[nodiscard]] bool contains(VertexId v) const {
    return is_of_rim(v) || spacing_.domain().is_fixed(mesh_.point(v));
  }

 private:
  [[nodiscard]] bool is_of_rim(VertexId v) const {
    constexpr double kMaxEdge = 1.45;  // Of the spacing: eight around a circle.
    const Domain& domain = spacing_.domain();
    if (v.value < 4 || mesh_.dimension(v) != VertexDimension::kCurve) return false;
    const MaterialSet curve = touched_by(v);
    if (!std::ranges::any_of(curve, [&](Material m) { return domain.is_beyond_opening(m); })) return false;
    const double wanted = spacing_.curve_spacing_at(mesh_.point(v), curve, spacing_.delta_mm());
    return wanted < spacing_.delta_mm() && gap_without(v, curve) > kMaxEdge * wanted;
  }
  [[nodiscard]] MaterialSet touched_by(VertexId v) const {
    constexpr double kTouch = 1e-2;  // Of the resolution.
    const Domain& domain = spacing_.domain();
    return domain.materials_near(mesh_.point(v), kTouch * domain.resolution_mm());
  }

  /// The distance between the vertices before and after one on its curve; infinite if it has none.
  [[nodiscard]] double gap_without(VertexId v, const MaterialSet& curve) const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<Vec3> ways;  // To the others, the nearest first.
    VertexStar star;
    std::unordered_set<std::uint32_t> seen = {v.value};
    for (const TetId t : star.gather(mesh_, v))
      for (const std::uint32_t w : mesh_.tet(t))
        if (w >= 4 && mesh_.dimension(VertexId(w)) <= VertexDimension::kCurve && seen.insert(w).second &&
            touched_by(VertexId(w)).contains_all(curve))
          ways.emplace_back(mesh_.point(VertexId(w)) - mesh_.point(v));
    std::ranges::sort(ways, [](const Vec3& a, const Vec3& b) {
      return a.squaredNorm() != b.squaredNorm() ? a.squaredNorm() < b.squaredNorm() : precedes(a, b);
    });
    for (const Vec3& way : ways)
      if (way.dot(ways.front()) < 0) return (way - ways.front()).norm();
    return kNone;
  }

  const TetMesh& mesh_;
  const Spacing& spacing_;
};

/// The corners of a face in an order that does not depend on their numbers.
std::array<VertexId, 3> corners_by_place(const TetMesh& mesh, TetId t, int f) {
  const Cell<3> face = mesh.face_corners(t, f);
  std::array<VertexId, 3> corners = {VertexId(face[0]), VertexId(face[1]), VertexId(face[2])};
  std::ranges::sort(corners, [&](VertexId v, VertexId w) { return precedes(mesh.point(v), mesh.point(w)); });
  return corners;
}

/// The vertex of a face that is to go; invalid if none may.
VertexId superfluous_vertex(const TetMesh& mesh, const NeededVertices& needed,
                            const std::array<VertexId, 3>& v, bool first) {
  constexpr double kCosineOfFlat = -0.64;  // 130 degrees.
  for (const VertexId w : v)
    if (mesh.dimension(w) == VertexDimension::kVolume) return w;
  const auto edge2 = [&](int k) {  // Opposite of corner k.
    return (mesh.point(v[(k + 1) % 3]) - mesh.point(v[(k + 2) % 3])).squaredNorm();
  };
  int longest = 0, shortest = 0;
  for (int k = 1; k < 3; ++k) {
    if (edge2(k) > edge2(longest)) longest = k;
    if (edge2(k) < edge2(shortest)) shortest = k;
  }
  const auto stays = [&](VertexId w) {
    return mesh.dimension(w) < VertexDimension::kCurve || needed.contains(w);
  };
  const Vec3 &a = mesh.point(v[longest]), to_b = mesh.point(v[(longest + 1) % 3]) - a,
             to_c = mesh.point(v[(longest + 2) % 3]) - a;
  const VertexId middle = v[longest];
  if (to_b.dot(to_c) < kCosineOfFlat * to_b.norm() * to_c.norm() && !stays(middle)) return middle;
  const VertexId one = v[(shortest + 1) % 3], other = v[(shortest + 2) % 3];
  const VertexId gone = may_rather_go(mesh, one, other, first) ? one : other;
  const VertexId rest = gone == one ? other : one;
  if (!stays(gone)) return gone;
  // Another vertex of a rim may go where this one may not.
  return mesh.dimension(rest) == mesh.dimension(gone) && !stays(rest) ? rest : VertexId();
}

}  // namespace

std::vector<VertexId> vertices_of_bad_faces(const TetMesh& mesh, const Rules& rules, const Spacing& spacing,
                                            double min_angle_deg, bool first) {
  const NeededVertices needed(mesh, spacing);
  const double max_cosine = cosine_deg(min_angle_deg);
  auto found = collect_from_tets<Removal>(mesh, [&](TetId t, std::vector<Removal>& out) {
    for (int f = 0; f < 4; ++f) {
      if (!rules.is_boundary(t, f) || mesh.link(t, f).tet() < t) continue;
      const std::array<VertexId, 3> v = corners_by_place(mesh, t, f);
      if (std::ranges::any_of(v, [](VertexId w) { return w.value < 4; })) continue;
      const bool is_off =
          std::ranges::any_of(v, [&](VertexId w) { return mesh.dimension(w) == VertexDimension::kVolume; });
      const double cosine = cosine_of_smallest_angle(mesh.point(v[0]), mesh.point(v[1]), mesh.point(v[2]));
      if (!is_off && !(cosine > max_cosine)) continue;
      if (const VertexId gone = superfluous_vertex(mesh, needed, v, first); gone.valid())
        out.push_back({cosine, gone});
    }
  });
  std::ranges::sort(found, [&](const Removal& a, const Removal& b) {
    return a.badness != b.badness ? a.badness > b.badness
                                  : precedes(mesh.point(a.vertex), mesh.point(b.vertex));
  });
  std::vector<VertexId> chosen;
  std::unordered_set<std::uint32_t> blocked;
  VertexStar star;
  for (const Removal& one : found) {
    if (blocked.contains(one.vertex.value)) continue;
    chosen.push_back(one.vertex);
    for (const TetId t : star.gather(mesh, one.vertex))
      blocked.insert(mesh.tet(t).begin(), mesh.tet(t).end());
  }
  return chosen;
}

}  // namespace lumesh::delaunay
