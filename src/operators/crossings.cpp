#include "lumesh/operators/crossings.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "neighbourhoods.hpp"

namespace lumesh::operators {
namespace {

/// The steps of undo_crossings().
class Undoing {
 public:
  Undoing(std::span<Vec3> points, std::span<const Cell<4>> tets, std::span<const Vec3> before,
          const MayBecome& may_become)
      : points_(points),
        tets_(tets),
        before_(before),
        may_become_(may_become),
        stars_(parallel::cells_around(tets, points.size())) {}

  [[nodiscard]] std::size_t count() const { return count_; }

  /// @return Whether any of the vertices was elsewhere.
  bool put_back(std::span<const std::uint32_t> vertices) {
    const std::size_t count = count_;
    for (const std::uint32_t v : vertices) {
      if (v >= before_.size() || points_[v] == before_[v]) continue;
      points_[v] = before_[v];
      waiting_.push_back(v);
      ++count_;
    }
    return count_ > count;
  }

  /// Tetrahedra that this has made worse than allowed go back as a whole, until there is none.
  void put_back_spoilt() {
    while (!waiting_.empty()) {
      const std::uint32_t v = waiting_.back();
      waiting_.pop_back();
      for (const std::uint32_t t : stars_.of(v))
        if (is_spoilt(t)) put_back(tets_[t]);
    }
  }

 private:
  /// Some corners have been put back but not all are there, and it may not be like that.
  [[nodiscard]] bool is_spoilt(std::uint32_t t) const {
    std::array<Vec3, 4> was, is;
    bool differs = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t v = tets_[t][k];
      is[k] = points_[v];
      was[k] = v < before_.size() ? before_[v] : is[k];
      differs |= was[k] != is[k];
    }
    return differs && (orient3d(is[0], is[1], is[2], is[3]) <= 0 || !may_become_(t, was, is));
  }

  std::span<Vec3> points_;
  std::span<const Cell<4>> tets_;
  std::span<const Vec3> before_;
  const MayBecome& may_become_;
  parallel::Adjacency stars_;  // The tetrahedra around each vertex.
  std::vector<std::uint32_t> waiting_;
  std::size_t count_ = 0;
};

}  // namespace

UndoReport undo_crossings(std::span<Vec3> points, std::span<const Cell<4>> tets,
                          std::span<const Cell<3>> outside, std::span<const Vec3> before,
                          const MayBecome& may_become) {
  std::vector<SelfCrossing> crossings = find_self_crossings(points, outside);
  if (crossings.empty()) return {};
  Undoing undoing(points, tets, before, may_become);
  for (;;
       crossings = find_self_crossings(points, outside)) {  // Ends: each round puts back at least one vertex.
    bool any = false;
    for (const SelfCrossing& crossing : crossings) {
      any |= undoing.put_back(outside[crossing.first]);
      any |= undoing.put_back(outside[crossing.second]);
    }
    if (!any) return {undoing.count(), crossings.size()};
    undoing.put_back_spoilt();
  }
}

std::vector<Cell<3>> outside_of(const BoundaryFaces& faces) {
  std::vector<Cell<3>> outside;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    if (!faces.tets[f][1].valid()) outside.push_back(faces.triangles[f]);
  return outside;
}

namespace {

/// The steps of draw_apart().
class DrawingApart {
 public:
  DrawingApart(TetMesh& mesh, const PatchShapes& shapes)
      : mesh_(mesh),
        moves_(mesh.vertex_slots(), Moves::kYes),
        normals_(mesh.vertex_slots(), Vec3::Zero()),
        is_held_flat_(mesh.vertex_slots(), false) {
    const BoundaryFaces faces = mesh.boundary_faces();
    outside_ = outside_of(faces);
    for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
      const auto patch = static_cast<std::size_t>(faces.patches[f]);
      const PatchShape& shape = shapes[patch];
      const bool is_plane = shape.freedom == PatchFreedom::kPlane;
      const PatchKind kind = mesh.info().patches[patch].kind;
      const bool stays_flat = is_plane && (kind == PatchKind::kOpening || kind == PatchKind::kSymmetry);
      for (const std::uint32_t v : faces.triangles[f]) {
        const bool is_on_curve = mesh.dimension(VertexId(v)) < VertexDimension::kSurface;
        if (shape.freedom == PatchFreedom::kFrozen || (is_on_curve && stays_flat))
          moves_[v] = Moves::kNever;
        else if (is_on_curve && moves_[v] == Moves::kYes)
          moves_[v] = Moves::kAtLast;
        if (is_plane) normals_[v] = shape.normal;
        if (stays_flat) is_held_flat_[v] = true;
      }
    }
  }

  std::size_t run() {
    constexpr int kRounds = 20;  // Then as many for those of curves too, and off flat walls.
    for (int round = 0;; ++round) {
      const std::vector<SelfCrossing> crossings = find_self_crossings(mesh_.points(), outside_);
      if (crossings.empty() || round == 2 * kRounds) return crossings.size();
      for (const std::uint32_t v : vertices_of(crossings))
        if (moves_[v] == Moves::kYes || (moves_[v] == Moves::kAtLast && round >= kRounds))
          step(VertexId(v), round >= kRounds && !is_held_flat_[v]);
    }
  }

 private:
  enum class Moves : std::uint8_t {
    kYes,
    kAtLast,  ///< A crease rather loses its place than that the mesh is invalid.
    kNever,
  };

  /// Ascending.
  [[nodiscard]] std::vector<std::uint32_t> vertices_of(const std::vector<SelfCrossing>& crossings) const {
    std::vector<std::uint32_t> vertices;
    for (const SelfCrossing& crossing : crossings)
      for (const std::uint32_t face : {crossing.first, crossing.second})
        vertices.insert(vertices.end(), outside_[face].begin(), outside_[face].end());
    sort_unique(vertices);
    return vertices;
  }

  void step(VertexId v, bool may_leave_plane) {
    constexpr double kPart = 0.2;  // Of the way.
    const auto tets = star_.gather(mesh_, v);
    const Vec3 before = mesh_.point(v);
    Vec3 move = kPart * (middle_around(tets, before) - before);
    if (!may_leave_plane) move -= normals_[v.value].dot(move) * normals_[v.value];
    mesh_.set_point(v, before + move);
    if (!std::ranges::all_of(tets, [&](TetId t) { return is_positive(mesh_, t); }))
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

  TetMesh& mesh_;
  std::vector<Cell<3>> outside_;
  std::vector<Moves> moves_;
  std::vector<Vec3> normals_;       // Of the plane that a vertex lies in.
  std::vector<bool> is_held_flat_;  // In an opening or a plane of symmetry.
  VertexStar star_;
};

}  // namespace

std::size_t draw_apart(TetMesh& mesh, const PatchShapes& shapes) {
  LUMESH_ASSERT(mesh.is_compact());
  return DrawingApart(mesh, shapes).run();
}

}  // namespace lumesh::operators
