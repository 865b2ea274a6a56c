#include "independent_set.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "conflicts.hpp"
#include "cut_off.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"

namespace lumesh::delaunay {
namespace {

/// Squared distance of the nearest of the vertices that a point would be joined to.
double nearest_vertex2(const TetMesh& mesh, const Vec3& point, std::span<const TetId> conflicts,
                       VertexDimension max_dimension) {
  double smallest2 = std::numeric_limits<double>::infinity();
  for (const TetId t : conflicts)
    for (const std::uint32_t v : mesh.tet(t))
      if (mesh.dimension(VertexId(v)) <= max_dimension)
        smallest2 = std::min(smallest2, (mesh.point(VertexId(v)) - point).squaredNorm());
  return smallest2;
}

/// True if a point of a surface would encroach on a vertex of a surface or curve, or a point of a curve on a
/// vertex of a curve. Vertices of surfaces that a point of a curve encroaches on are removed later; it only
/// may not touch one, which could be there for good.
bool is_near_a_vertex(const TetMesh& mesh, const Candidate& candidate, std::span<const TetId> conflicts) {
  constexpr double kMin = 0.3, kMinOnCurve = 0.4, kTouch = 2e-3;  // Of the spacing.
  const double min_distance =
      (candidate.dimension <= VertexDimension::kCurve ? kMinOnCurve : kMin) * candidate.spacing;
  const auto is_within = [&](double distance, VertexDimension max_dimension) {
    return nearest_vertex2(mesh, candidate.point, conflicts, max_dimension) < distance * distance;
  };
  return is_within(min_distance, std::max(candidate.dimension, VertexDimension::kCurve)) ||
         is_within(kTouch * candidate.spacing, VertexDimension::kSurface);
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

/// Two points that replace the same tetrahedron, which a third one of higher priority claims, may be near
/// each other.
struct SharedTet {
  TetId tet;
  std::uint32_t candidate;
  friend auto operator<=>(const SharedTet&, const SharedTet&) = default;
};

/// Drops each candidate that lies too near to one of higher priority that claims the same tetrahedron. Who
/// marks one as lost does not matter, and marks are read after the loop: relaxed is enough.
template <class IsTooNear>
void lose_to_each_other(std::vector<SharedTet> shared, const IsTooNear& is_too_near,
                        std::vector<std::uint32_t>& lost) {
  parallel::sort(shared.begin(), shared.end());
  parallel::for_each_index(shared.size(), [&](std::size_t i) {
    for (std::size_t j = i; j > 0 && shared[j - 1].tet == shared[i].tet; --j)
      if (is_too_near(shared[j - 1].candidate, shared[i].candidate))
        parallel::store_relaxed(lost[shared[i].candidate], 1);
  });
}

}  // namespace

/// A point of a surface or volume that encroaches on a piece of a curve is replaced by one that divides it.
/// @return true if it changed the candidate.
bool IndependentSet::spare_curves(const TetMesh& mesh, Candidate& candidate,
                                  std::span<const TetId> conflicts) const {
  if (candidate.dimension <= VertexDimension::kCurve) return false;
  const auto piece = encroached_piece(mesh, spacing_.domain(), candidate.point, conflicts);
  if (!piece) return false;
  const double length = (piece->to - piece->from).norm();
  const auto x = spacing_.domain().project(0.5 * (piece->from + piece->to), piece->materials, 0.5 * length);
  constexpr double kMin = 0.35;  // Of the piece's length.
  if (!x || is_cut_off(spacing_.domain(), *x) ||
      std::min((*x - piece->from).norm(), (*x - piece->to).norm()) < kMin * length)
    return false;
  candidate.point = *x;
  candidate.dimension = dimension_of(piece->materials);
  candidate.spacing = std::max(candidate.spacing, length);
  return true;
}

std::vector<IndependentSet::Replacement> IndependentSet::replacements(
    const TetMesh& mesh, std::vector<Candidate>& candidates) const {
  std::vector<Replacement> replaced(candidates.size());
  parallel::for_each_block(
      candidates.size(), 64, [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
        ConflictFinder finder;
        for (std::size_t i = begin; i < end; ++i) {
          auto found = finder.find(mesh, candidates[i].point, candidates[i].tet);
          if (spare_curves(mesh, candidates[i], found))
            found = finder.find(mesh, candidates[i].point, candidates[i].tet);
          if (is_near_a_vertex(mesh, candidates[i], found)) continue;
          replaced[i] = {{found.begin(), found.end()},
                         nearest_vertex2(mesh, candidates[i].point, found, VertexDimension::kVolume)};
        }
      });
  return replaced;
}

/// Where neighbours all ask for points inside, most would not get theirs: finding the tetrahedra that each
/// would replace costs more than anything else.
std::vector<Candidate> IndependentSet::without_lower_priority_neighbours(TetMesh& mesh,
                                                                         std::vector<Candidate> candidates,
                                                                         std::uint32_t stamp) {
  const auto rank_of = [&](std::size_t i) { return static_cast<std::uint32_t>(candidates.size() - i); };
  const auto is_inside = [&](std::size_t i) { return candidates[i].dimension == VertexDimension::kVolume; };
  parallel::for_each_index(candidates.size(), [&](std::size_t i) {
    if (is_inside(i)) claims_[candidates[i].tet.value] = rank_of(i);
  });
  auto kept =
      parallel::collect<Candidate>(candidates.size(), [&](std::size_t i, std::vector<Candidate>& out) {
        bool is_first = true;
        for (int f = 0; f < 4 && is_inside(i); ++f) {
          const FaceLink behind = mesh.link(candidates[i].tet, f);
          is_first &= behind.is_boundary() || claims_[behind.tet().value] <= rank_of(i);
        }
        if (is_first)
          out.push_back(candidates[i]);
        else
          mesh.set_stamp(candidates[i].tet, stamp);
      });
  parallel::for_each_index(candidates.size(), [&](std::size_t i) {
    if (is_inside(i)) claims_[candidates[i].tet.value] = 0;
  });
  return kept;
}

std::vector<Candidate> IndependentSet::select(TetMesh& mesh, std::vector<Candidate> candidates,
                                              std::uint32_t stamp) {
  claims_.resize(mesh.tet_slots(), 0);
  parallel::sort(candidates.begin(), candidates.end(), has_higher_priority);
  candidates = without_lower_priority_neighbours(mesh, std::move(candidates), stamp);
  const std::vector<Replacement> replaced = replacements(mesh, candidates);
  const auto for_each_candidate = [&](const auto& work) {
    parallel::for_each_index(candidates.size(), work);
  };
  for_each_candidate([&](std::size_t i) {
    for (const TetId t : replaced[i].tets)
      parallel::raise_to(claims_[t.value], static_cast<std::uint32_t>(candidates.size() - i));
  });
  // Claims do not change in loops that read them, and become 0 whoever of several clears one.
  const auto first_of = [&](TetId t) { return candidates.size() - parallel::load_relaxed(claims_[t.value]); };
  const auto is_too_near = [&](std::size_t j, std::size_t i) {
    return (candidates[j].point - candidates[i].point).squaredNorm() < replaced[i].reach2;
  };
  std::vector<std::uint32_t> lost(candidates.size(), 0);
  const auto shared = parallel::collect<SharedTet>(candidates.size(), [&](std::size_t i, auto& out) {
    const std::vector<TetId>& tets = replaced[i].tets;
    lost[i] = static_cast<std::uint32_t>(tets.empty() || std::ranges::any_of(tets, [&](TetId t) {
                                           return first_of(t) != i && is_too_near(first_of(t), i);
                                         }));
    if (lost[i] != 0) return;
    for (const TetId t : tets)
      if (first_of(t) != i) out.push_back({t, static_cast<std::uint32_t>(i)});
  });
  lose_to_each_other(shared, is_too_near, lost);
  for_each_candidate([&](std::size_t i) {
    for (const TetId t : replaced[i].tets) parallel::store_relaxed(claims_[t.value], 0);
    // Looked at again in the next round; if it is gone by then, so is the stamp.
    if (!replaced[i].tets.empty()) mesh.set_stamp(candidates[i].tet, stamp);
  });
  return parallel::collect<Candidate>(candidates.size(), [&](std::size_t i, std::vector<Candidate>& out) {
    if (lost[i] == 0) out.push_back(candidates[i]);
  });
}

}  // namespace lumesh::delaunay
