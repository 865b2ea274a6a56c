#include "lumesh/operators/crossings.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/self_crossings.hpp"
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

namespace {

std::vector<Cell<3>> outside_of(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<Cell<3>> outside;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    if (mesh.info().patches[static_cast<std::size_t>(faces.patches[f])].kind != PatchKind::kInterface)
      outside.push_back(faces.triangles[f]);
  return outside;
}

}  // namespace

std::size_t undo_crossings(TetMesh& mesh, std::span<const Vec3> before, const MayBecome& may_become) {
  LUMESH_ASSERT(mesh.is_compact());
  std::vector<Vec3> points(mesh.points().begin(), mesh.points().end());
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::size_t left = undo_crossings(points, mesh.tets(), outside_of(mesh, faces), before, may_become);
  parallel::for_each_index(points.size(), [&](std::size_t v) {
    mesh.set_point(VertexId(static_cast<std::uint32_t>(v)), points[v]);
  });
  return left;
}

std::size_t draw_apart(TetMesh& mesh) {
  LUMESH_ASSERT(mesh.is_compact());
  constexpr int kRounds = 20;
  constexpr double kStep = 0.2;  // Of the way to the middle of the vertices around.
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<Cell<3>> outside = outside_of(mesh, faces);
  // Of the opening that a vertex lies in; its last one, where there are several.
  std::vector<Vec3> normals(mesh.vertex_slots(), Vec3::Zero());
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    if (mesh.info().patches[static_cast<std::size_t>(faces.patches[f])].kind != PatchKind::kOpening) continue;
    const auto& [a, b, c] = faces.triangles[f];
    const auto& at = [&](std::uint32_t v) -> const Vec3& { return mesh.point(VertexId(v)); };
    const Vec3 normal = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
    for (const std::uint32_t v : faces.triangles[f]) normals[v] = normal;
  }
  VertexStar star;
  const auto step = [&](VertexId v) {
    const auto tets = star.gather(mesh, v);
    Vec3 sum = Vec3::Zero();
    for (const TetId t : tets)
      for (int k = 0; k < 4; ++k) sum += mesh.corner(t, k);
    const Vec3 before = mesh.point(v);
    const auto count = static_cast<double>(tets.size());
    const Vec3 middle = (sum - count * before) / (3 * count);
    Vec3 move = kStep * (middle - before);
    move -= normals[v.value].dot(move) * normals[v.value];
    mesh.set_point(v, before + move);
    const bool is_positive = std::all_of(tets.begin(), tets.end(), [&](TetId t) {
      return orient3d(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3)) > 0;
    });
    if (!is_positive) mesh.set_point(v, before);
  };
  for (int round = 0;; ++round) {
    const std::vector<SelfCrossing> crossings = find_self_crossings(mesh.points(), outside);
    if (crossings.empty() || round == kRounds) return crossings.size();
    std::vector<std::uint32_t> vertices;
    for (const SelfCrossing& crossing : crossings)
      for (const std::uint32_t face : {crossing.first, crossing.second})
        vertices.insert(vertices.end(), outside[face].begin(), outside[face].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const std::uint32_t v : vertices) step(VertexId(v));
  }
}

}  // namespace lumesh::operators
