#include "lumesh/operators/crossings.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

class Undoing {
 public:
  Undoing(std::span<Vec3> points, std::span<const Cell<4>> tets, std::span<const Vec3> before,
          const MayBecome& may_become)
      : points_(points), tets_(tets), before_(before), may_become_(may_become) {}

  /// @return Whether any of the vertices was elsewhere.
  bool put_back(std::span<const std::uint32_t> vertices) {
    bool any = false;
    for (const std::uint32_t v : vertices) {
      if (v >= before_.size() || points_[v] == before_[v]) continue;
      points_[v] = before_[v];
      any = true;
    }
    return any;
  }

  /// Tetrahedra that this has made worse than allowed go back as a whole, until there is none.
  void put_back_spoilt() {
    for (bool any = true; any;) {  // Ends: each round puts back at least one vertex.
      const auto spoilt = parallel::collect<std::uint32_t>(tets_.size(), [&](std::size_t t, auto& out) {
        if (is_spoilt(t)) out.push_back(static_cast<std::uint32_t>(t));
      });
      any = false;
      for (const std::uint32_t t : spoilt) any |= put_back(tets_[t]);
    }
  }

 private:
  [[nodiscard]] bool is_back(std::uint32_t v) const { return v < before_.size() && points_[v] == before_[v]; }

  /// Some corners but not all are back, and it may not be like that.
  [[nodiscard]] bool is_spoilt(std::size_t t) const {
    const Cell<4>& tet = tets_[t];
    const auto back = std::count_if(tet.begin(), tet.end(), [&](std::uint32_t v) { return is_back(v); });
    if (back == 0 || back == 4) return false;
    std::array<Vec3, 4> was, is;
    for (std::size_t k = 0; k < 4; ++k) {
      is[k] = points_[tet[k]];
      was[k] = tet[k] < before_.size() ? before_[tet[k]] : is[k];
    }
    return orient3d(is[0], is[1], is[2], is[3]) <= 0 || !may_become_(t, was, is);
  }

  std::span<Vec3> points_;
  std::span<const Cell<4>> tets_;
  std::span<const Vec3> before_;
  const MayBecome& may_become_;
};

}  // namespace

std::size_t undo_crossings(std::span<Vec3> points, std::span<const Cell<4>> tets,
                           std::span<const Cell<3>> outside, std::span<const Vec3> before,
                           const MayBecome& may_become) {
  Undoing undoing(points, tets, before, may_become);
  for (;;) {  // Ends: each round puts back at least one vertex.
    const std::vector<SelfCrossing> crossings = find_self_crossings(points, outside);
    bool any = false;
    for (const SelfCrossing& crossing : crossings) {
      any |= undoing.put_back(outside[crossing.first]);
      any |= undoing.put_back(outside[crossing.second]);
    }
    if (!any) return crossings.size();
    undoing.put_back_spoilt();
  }
}

std::vector<Cell<3>> outside_of(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<Cell<3>> outside;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    if (mesh.info().patches[static_cast<std::size_t>(faces.patches[f])].kind != PatchKind::kInterface)
      outside.push_back(faces.triangles[f]);
  return outside;
}

namespace {

/// The steps of draw_apart().
class DrawingApart {
 public:
  explicit DrawingApart(TetMesh& mesh) : mesh_(mesh), normals_(mesh.vertex_slots(), Vec3::Zero()) {
    const BoundaryFaces faces = mesh.boundary_faces();
    outside_ = outside_of(mesh, faces);
    for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
      if (mesh.info().patches[static_cast<std::size_t>(faces.patches[f])].kind != PatchKind::kOpening)
        continue;
      const auto& [a, b, c] = faces.triangles[f];
      const Vec3 normal = triangle_normal(at(a), at(b), at(c));
      for (const std::uint32_t v : faces.triangles[f]) normals_[v] = normal;
    }
  }

  std::size_t run() {
    constexpr int kRounds = 20;
    for (int round = 0;; ++round) {
      const std::vector<SelfCrossing> crossings = find_self_crossings(mesh_.points(), outside_);
      if (crossings.empty() || round == kRounds) return crossings.size();
      for (const std::uint32_t v : vertices_of(crossings)) step(VertexId(v));
    }
  }

 private:
  [[nodiscard]] const Vec3& at(std::uint32_t v) const { return mesh_.point(VertexId(v)); }

  /// Ascending.
  [[nodiscard]] std::vector<std::uint32_t> vertices_of(const std::vector<SelfCrossing>& crossings) const {
    std::vector<std::uint32_t> vertices;
    for (const SelfCrossing& crossing : crossings)
      for (const std::uint32_t face : {crossing.first, crossing.second})
        vertices.insert(vertices.end(), outside_[face].begin(), outside_[face].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
  }

  void step(VertexId v) {
    constexpr double kPart = 0.2;  // Of the way.
    const auto tets = star_.gather(mesh_, v);
    const Vec3 before = mesh_.point(v);
    Vec3 move = kPart * (middle_around(tets, before) - before);
    move -= normals_[v.value].dot(move) * normals_[v.value];
    mesh_.set_point(v, before + move);
    if (!std::all_of(tets.begin(), tets.end(), [&](TetId t) { return is_positive(t); }))
      mesh_.set_point(v, before);
  }

  /// The mean of the other corners, those of many tetrahedra counted more.
  [[nodiscard]] Vec3 middle_around(std::span<const TetId> tets, const Vec3& own) const {
    Vec3 sum = Vec3::Zero();
    for (const TetId t : tets)
      for (int k = 0; k < 4; ++k) sum += mesh_.corner(t, k);
    const auto count = static_cast<double>(tets.size());
    return (sum - count * own) / (3 * count);
  }

  [[nodiscard]] bool is_positive(TetId t) const {
    return orient3d(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2), mesh_.corner(t, 3)) > 0;
  }

  TetMesh& mesh_;
  std::vector<Cell<3>> outside_;
  std::vector<Vec3> normals_;  // Of the opening that a vertex lies in, of the last one if there are several.
  VertexStar star_;
};

}  // namespace

std::size_t draw_apart(TetMesh& mesh) {
  LUMESH_ASSERT(mesh.is_compact());
  return DrawingApart(mesh).run();
}

}  // namespace lumesh::operators
