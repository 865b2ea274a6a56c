#include "granting.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "conflicts.hpp"
#include "cut_off.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"

namespace lumesh::delaunay {
namespace {

/// Of the vertices that a point would be joined to, which the nearest one is among.
double nearest_vertex2(const TetMesh& mesh, const Vec3& point, std::span<const TetId> conflicts,
                       VertexDimension most) {
  double least2 = std::numeric_limits<double>::infinity();
  for (const TetId t : conflicts)
    for (const std::uint32_t v : mesh.tet(t))
      if (mesh.dimension(VertexId(v)) <= most)
        least2 = std::min(least2, (mesh.point(VertexId(v)) - point).squaredNorm());
  return least2;
}

/// True if a point of a surface would crowd one that is there, or one of a curve another one of that kind:
/// those of surfaces give way to it.
bool is_near_a_vertex(const TetMesh& mesh, const Wish& wish, std::span<const TetId> conflicts) {
  constexpr double kLeast = 0.3, kLeastOnCurve = 0.4;  // Of the spacing.
  const double least = (wish.dimension <= VertexDimension::kCurve ? kLeastOnCurve : kLeast) * wish.spacing;
  return nearest_vertex2(mesh, wish.point, conflicts, std::max(wish.dimension, VertexDimension::kCurve)) <
         least * least;
}

/// A piece of a curve, and the materials that meet there.
struct CurvePiece {
  Vec3 from, to;
  MaterialSet materials;
};

MaterialSet common_materials(const Domain& domain, const Vec3& a, const Vec3& b) {
  const double touch = 1e-2 * domain.resolution_mm();
  const MaterialSet at_b = domain.materials_near(b, touch);
  MaterialSet common;
  for (const Material m : domain.materials_near(a, touch))
    if (at_b.contains(m)) common.insert(m);
  return common;
}

/// The piece of a curve among what a point would replace in whose smallest sphere the point lies: the piece
/// would break. If there are several, the first by its middle.
std::optional<CurvePiece> encroached_piece(const TetMesh& mesh, const Domain& domain, const Vec3& point,
                                           std::span<const TetId> conflicts) {
  const auto is_on_curve = [&](TetId t, int corner) {
    const VertexId v = mesh.vertex(t, corner);
    return v.value >= 4 && mesh.dimension(v) <= VertexDimension::kCurve;
  };
  std::optional<CurvePiece> found;
  for (const TetId t : conflicts)
    for (const auto& [i, j] : kTetEdges) {
      if (!is_on_curve(t, i) || !is_on_curve(t, j)) continue;
      const Vec3 &a = mesh.corner(t, i), &b = mesh.corner(t, j);
      if ((point - a).dot(point - b) >= 0) continue;
      if (found && !precedes(a + b, found->from + found->to)) continue;
      const MaterialSet common = common_materials(domain, a, b);
      if (common.size() > 2) found = {a, b, common};
    }
  return found;
}

/// Of points that replace a tetrahedron, which a more urgent third one claims, two may be near each other.
struct SharedTet {
  TetId tet;
  std::uint32_t wish;
  friend auto operator<=>(const SharedTet&, const SharedTet&) = default;
};

/// Among those that claim a tetrahedron, what a more urgent one is too near to loses.
template <class IsTooNear>
void lose_to_each_other(std::vector<SharedTet> shared, const IsTooNear& is_too_near,
                        std::vector<std::uint32_t>& lost) {
  parallel::sort(shared.begin(), shared.end());
  parallel::for_each_index(shared.size(), [&](std::size_t i) {
    for (std::size_t j = i; j > 0 && shared[j - 1].tet == shared[i].tet; --j)
      if (is_too_near(shared[j - 1].wish, shared[i].wish)) parallel::store_relaxed(lost[shared[i].wish], 1);
  });
}

}  // namespace

/// Points of surfaces and volumes that would break a piece of a curve give way to one that divides it.
/// @return true if it changed the wish.
bool Granting::spare_curves(const TetMesh& mesh, Wish& wish, std::span<const TetId> conflicts) const {
  if (wish.dimension <= VertexDimension::kCurve) return false;
  const auto piece = encroached_piece(mesh, spacing_.domain(), wish.point, conflicts);
  if (!piece) return false;
  const double length = (piece->to - piece->from).norm();
  const auto x = spacing_.domain().project(0.5 * (piece->from + piece->to), piece->materials, 0.5 * length);
  constexpr double kLeast = 0.35;  // Of the piece's length.
  if (!x || is_cut_off(spacing_.domain(), *x) ||
      std::min((*x - piece->from).norm(), (*x - piece->to).norm()) < kLeast * length)
    return false;
  wish.point = *x;
  wish.dimension = dimension_of(piece->materials);
  wish.spacing = std::max(wish.spacing, length);
  return true;
}

std::vector<Granting::Replacement> Granting::replacements(const TetMesh& mesh,
                                                          std::vector<Wish>& wishes) const {
  std::vector<Replacement> replaced(wishes.size());
  parallel::for_each_block(wishes.size(), 64, [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
    ConflictFinder finder;
    for (std::size_t i = begin; i < end; ++i) {
      auto found = finder.find(mesh, wishes[i].point, wishes[i].tet);
      if (spare_curves(mesh, wishes[i], found)) found = finder.find(mesh, wishes[i].point, wishes[i].tet);
      if (is_near_a_vertex(mesh, wishes[i], found)) continue;
      replaced[i] = {{found.begin(), found.end()},
                     nearest_vertex2(mesh, wishes[i].point, found, VertexDimension::kVolume)};
    }
  });
  return replaced;
}

/// Of neighbours that all wish for points inside, most would not get theirs: finding out what each would
/// replace costs more than anything else.
std::vector<Wish> Granting::without_those_beside_more_urgent_ones(TetMesh& mesh, std::vector<Wish> wishes,
                                                                  std::uint32_t stamp) {
  const auto rank_of = [&](std::size_t i) { return static_cast<std::uint32_t>(wishes.size() - i); };
  const auto is_inside = [&](std::size_t i) { return wishes[i].dimension == VertexDimension::kVolume; };
  parallel::for_each_index(wishes.size(), [&](std::size_t i) {
    if (is_inside(i)) claims_[wishes[i].tet.value] = rank_of(i);
  });
  auto kept = parallel::collect<Wish>(wishes.size(), [&](std::size_t i, std::vector<Wish>& out) {
    bool is_first = true;
    for (int f = 0; f < 4 && is_inside(i); ++f) {
      const FaceLink behind = mesh.link(wishes[i].tet, f);
      is_first &= behind.is_boundary() || claims_[behind.tet().value] <= rank_of(i);
    }
    if (is_first)
      out.push_back(wishes[i]);
    else
      mesh.set_stamp(wishes[i].tet, stamp);
  });
  parallel::for_each_index(wishes.size(), [&](std::size_t i) {
    if (is_inside(i)) claims_[wishes[i].tet.value] = 0;
  });
  return kept;
}

std::vector<Wish> Granting::granted(TetMesh& mesh, std::vector<Wish> wishes, std::uint32_t stamp) {
  claims_.resize(mesh.tet_slots(), 0);
  parallel::sort(wishes.begin(), wishes.end(), is_more_urgent);
  wishes = without_those_beside_more_urgent_ones(mesh, std::move(wishes), stamp);
  const std::vector<Replacement> replaced = replacements(mesh, wishes);
  const auto of_wishes = [&](const auto& work) { parallel::for_each_index(wishes.size(), work); };
  of_wishes([&](std::size_t i) {
    for (const TetId t : replaced[i].tets)
      parallel::raise_to(claims_[t.value], static_cast<std::uint32_t>(wishes.size() - i));
  });
  const auto first_of = [&](TetId t) { return wishes.size() - parallel::load_relaxed(claims_[t.value]); };
  const auto is_too_near = [&](std::size_t j, std::size_t i) {
    return (wishes[j].point - wishes[i].point).squaredNorm() < replaced[i].reach2;
  };
  std::vector<std::uint32_t> lost(wishes.size(), 0);
  const auto shared = parallel::collect<SharedTet>(wishes.size(), [&](std::size_t i, auto& out) {
    const std::vector<TetId>& tets = replaced[i].tets;
    lost[i] = static_cast<std::uint32_t>(tets.empty() || std::any_of(tets.begin(), tets.end(), [&](TetId t) {
                                           return first_of(t) != i && is_too_near(first_of(t), i);
                                         }));
    if (lost[i] != 0) return;
    for (const TetId t : tets)
      if (first_of(t) != i) out.push_back({t, static_cast<std::uint32_t>(i)});
  });
  lose_to_each_other(shared, is_too_near, lost);
  of_wishes([&](std::size_t i) {
    for (const TetId t : replaced[i].tets) parallel::store_relaxed(claims_[t.value], 0);
    // Looked at again in the next round; if it is gone by then, so is the stamp.
    if (!replaced[i].tets.empty()) mesh.set_stamp(wishes[i].tet, stamp);
  });
  return parallel::collect<Wish>(wishes.size(), [&](std::size_t i, std::vector<Wish>& out) {
    if (lost[i] == 0) out.push_back(wishes[i]);
  });
}

}  // namespace lumesh::delaunay
