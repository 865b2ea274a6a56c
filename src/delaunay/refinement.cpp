#include "refinement.hpp"

#include <algorithm>
#include <chrono>
#include <tuple>

#include "conflicts.hpp"
#include "lift.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"
#include "topology.hpp"

namespace lumesh::delaunay {
namespace {

constexpr std::size_t kBlock = 1024;

VertexDimension dimension_of(const MaterialSet& materials) {
  return materials.size() == 2   ? VertexDimension::kSurface
         : materials.size() == 3 ? VertexDimension::kCurve
                                 : VertexDimension::kCorner;
}

bool is_more_urgent(const Wish& a, const Wish& b) {
  if (a.urgency != b.urgency) return a.urgency > b.urgency;
  return precedes(a.point, b.point);
}

/// What a point that is wished for would replace.
struct Replacement {
  std::vector<TetId> tets;
  double reach2 = 0;  ///< Square of the distance to the nearest vertex.
};

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
  constexpr double kLeast = 0.3, kLeastOnCurve = 0.15;  // Of the spacing.
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

}  // namespace

/// Points of surfaces and volumes that would break a piece of a curve give way to one that divides it.
/// @return true if it changed the wish.
bool Refinement::spare_curves(Wish& wish, std::span<const TetId> conflicts) const {
  if (wish.dimension <= VertexDimension::kCurve) return false;
  const auto piece = encroached_piece(mesh_, spacing_.domain(), wish.point, conflicts);
  if (!piece) return false;
  const double length = (piece->to - piece->from).norm();
  const auto x = spacing_.domain().project(0.5 * (piece->from + piece->to), piece->materials, 0.5 * length);
  constexpr double kLeast = 0.35;  // Of the piece's length.
  if (!x || std::min((*x - piece->from).norm(), (*x - piece->to).norm()) < kLeast * length) return false;
  wish.point = *x;
  wish.dimension = dimension_of(piece->materials);
  wish.spacing = std::max(wish.spacing, length);
  return true;
}

void Refinement::insert_seeds(const Seeds& seeds, std::span<const std::uint32_t> boundary) {
  std::vector<operators::DelaunayExecution::NewVertex> points(boundary.size() + seeds.inner.size() +
                                                              seeds.outer.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) {
    if (i < boundary.size()) {
      const BoundaryCandidate& one = seeds.boundary[boundary[i]];
      points[i] = {one.point, dimension_of(one.materials), {}};
      if (one.materials.size() == 2)
        points[i].point =
            lifted(spacing_.domain(), one.point, one.materials[0], one.materials[1], one.spacing);
    } else {
      const std::size_t rest = i - boundary.size();
      points[i] = {rest < seeds.inner.size() ? seeds.inner[rest] : seeds.outer[rest - seeds.inner.size()],
                   VertexDimension::kVolume,
                   {}};
    }
  });
  execution_.insert(points, stamp_);
}

std::vector<TetId> Refinement::fresh_tets() const {
  return parallel::collect<TetId>(
      mesh_.tet_slots(),
      [&](std::size_t i, std::vector<TetId>& out) {
        if (const TetId t(static_cast<std::uint32_t>(i)); mesh_.stamp(t) == stamp_) out.push_back(t);
      },
      16384);
}

std::vector<Circumsphere> Refinement::find_materials(std::span<const TetId> fresh) {
  std::vector<Circumsphere> spheres(fresh.size());
  parallel::for_each_index(
      fresh.size(),
      [&](std::size_t i) {
        spheres[i] = circumsphere(mesh_, fresh[i]);
        mesh_.set_label(fresh[i], static_cast<Label>(rules_.material_at(spheres[i])));
      },
      256);
  return spheres;
}

std::vector<Wish> Refinement::wishes_of(std::span<const TetId> fresh,
                                        std::span<const Circumsphere> spheres) const {
  return parallel::collect<Wish>(
      fresh.size(),
      [&](std::size_t i, std::vector<Wish>& out) {
        const TetId t = fresh[i];
        const Circumsphere& sphere = spheres[i];
        for (int f = 0; f < 4; ++f) {
          if (!rules_.is_boundary(t, f)) continue;
          const TetId other = mesh_.link(t, f).tet();
          // Once for each face, from the same side whatever the numbers are.
          if (mesh_.stamp(other) == stamp_ && mesh_.label(other) < mesh_.label(t)) continue;
          if (const auto wish = rules_.wish_of_face(t, f, sphere)) out.push_back(*wish);
        }
        if (const auto wish = rules_.wish_of_tet(t, sphere)) out.push_back(*wish);
      },
      kBlock);
}

std::vector<VertexId> Refinement::pinched() const {
  return pinched_ && !has_changed_ ? *pinched_ : pinched_vertices(mesh_, spacing_.domain());
}

/// All are looked for once; from then on it is enough to look where something is new.
std::vector<VertexId> Refinement::newly_pinched(std::span<const TetId> fresh) {
  if (!pinched_) return *(pinched_ = pinched_vertices(mesh_, spacing_.domain()));
  std::vector<VertexId> suspects;
  for (const TetId t : fresh)
    for (const std::uint32_t v : mesh_.tet(t))
      if (v >= 4) suspects.emplace_back(v);
  std::sort(suspects.begin(), suspects.end());
  suspects.erase(std::unique(suspects.begin(), suspects.end()), suspects.end());
  std::erase_if(*pinched_, [&](VertexId v) {
    return !mesh_.alive(v) || std::binary_search(suspects.begin(), suspects.end(), v);
  });
  std::vector<VertexId> found = pinched_among(mesh_, spacing_.domain(), suspects);
  pinched_->insert(pinched_->end(), found.begin(), found.end());
  return found;
}

std::vector<Wish> Refinement::wishes_of_topology(std::span<const VertexId> pinched) const {
  return parallel::collect_blocks<Wish>(
      pinched.size(), 16, [&](std::size_t begin, std::size_t end, std::vector<Wish>& out) {
        VertexStar star;
        for (std::size_t i = begin; i < end; ++i) {
          std::optional<Wish> best;
          for (const TetId t : star.gather(mesh_, pinched[i])) {
            const Circumsphere sphere = circumsphere(mesh_, t);
            for (int f = 0; f < 4; ++f) {
              if (mesh_.vertex(t, f) == pinched[i] || !rules_.is_boundary(t, f)) continue;
              const auto wish = rules_.centre_of_face(t, f, sphere);
              if (wish && (!best || is_more_urgent(*wish, *best))) best = wish;
            }
          }
          if (best) out.push_back(*best);
        }
      });
}

/// Points may be put in together if none of them would be nearer to another one than to what is there: the
/// triangulation does not depend on their order.
std::vector<Wish> Refinement::granted(std::vector<Wish> wishes) {
  parallel::sort(wishes.begin(), wishes.end(), is_more_urgent);
  claims_.resize(mesh_.tet_slots(), 0);
  std::vector<Replacement> replaced(wishes.size());
  parallel::for_each_block(wishes.size(), 64, [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
    ConflictFinder finder;
    for (std::size_t i = begin; i < end; ++i) {
      auto found = finder.find(mesh_, wishes[i].point, wishes[i].tet);
      if (spare_curves(wishes[i], found)) found = finder.find(mesh_, wishes[i].point, wishes[i].tet);
      if (is_near_a_vertex(mesh_, wishes[i], found)) continue;
      replaced[i] = {{found.begin(), found.end()},
                     nearest_vertex2(mesh_, wishes[i].point, found, VertexDimension::kVolume)};
      for (const TetId t : found)
        parallel::raise_to(claims_[t.value], static_cast<std::uint32_t>(wishes.size() - i));
    }
  });
  // Of what is claimed twice, the more urgent one knows.
  const auto rival_of = [&](TetId t) { return wishes.size() - parallel::load_relaxed(claims_[t.value]); };
  auto won = parallel::collect<Wish>(wishes.size(), [&](std::size_t i, std::vector<Wish>& out) {
    const bool is_free = std::all_of(replaced[i].tets.begin(), replaced[i].tets.end(), [&](TetId t) {
      const std::size_t j = rival_of(t);
      return j == i || (wishes[j].point - wishes[i].point).squaredNorm() >= replaced[i].reach2;
    });
    if (is_free && !replaced[i].tets.empty()) out.push_back(wishes[i]);
  });
  parallel::for_each_index(wishes.size(), [&](std::size_t i) {
    for (const TetId t : replaced[i].tets)
      if (rival_of(t) == i) parallel::store_relaxed(claims_[t.value], 0);
    // Looked at again in the next round; if it is gone by then, so is the stamp.
    if (!replaced[i].tets.empty()) mesh_.set_stamp(wishes[i].tet, stamp_ + 1);
  });
  return won;
}

/// Inner vertices too near to new ones of a surface (R6), and those of surfaces to new ones of curves.
std::vector<VertexId> Refinement::crowding(std::span<const VertexId> made,
                                           std::span<const Wish> wishes) const {
  auto found = parallel::collect_blocks<VertexId>(
      made.size(), 64, [&](std::size_t begin, std::size_t end, std::vector<VertexId>& out) {
        VertexStar star;
        for (std::size_t i = begin; i < end; ++i) {
          const VertexId v = made[i];
          if (!v.valid() || mesh_.dimension(v) == VertexDimension::kVolume) continue;
          constexpr double kNear = 0.5, kNearCurve = 0.3;
          const auto gives_way = [&](VertexId w) {
            const VertexDimension dimension = mesh_.dimension(w);
            if (dimension <= VertexDimension::kCurve || dimension <= mesh_.dimension(v)) return false;
            const double least =
                (dimension == VertexDimension::kVolume ? kNear : kNearCurve) * wishes[i].spacing;
            return (mesh_.point(w) - mesh_.point(v)).squaredNorm() < least * least;
          };
          for (const TetId t : star.gather(mesh_, v))
            for (const std::uint32_t w : mesh_.tet(t))
              if (w >= 4 && gives_way(VertexId(w))) out.emplace_back(w);
        }
      });
  parallel::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

DelaunayRound Refinement::run_round() {
  const auto start = std::chrono::steady_clock::now();
  DelaunayRound round;
  const std::vector<TetId> fresh = fresh_tets();
  const std::vector<Circumsphere> spheres = find_materials(fresh);
  std::vector<Wish> wishes = wishes_of(fresh, spheres);
  round.tets_looked_at = fresh.size();
  // Shapes first: they mend most of it.
  if (pinched_ || std::none_of(wishes.begin(), wishes.end(),
                               [](const Wish& w) { return w.dimension != VertexDimension::kVolume; })) {
    const std::vector<Wish> more = wishes_of_topology(newly_pinched(fresh));
    wishes.insert(wishes.end(), more.begin(), more.end());
    round.topology_wishes = more.size();
  }
  for (const Wish& wish : wishes)
    ++(wish.dimension == VertexDimension::kVolume ? round.volume_wishes : round.surface_wishes);
  const std::vector<Wish> winners = granted(std::move(wishes));
  ++stamp_;
  std::vector<operators::DelaunayExecution::NewVertex> points(winners.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) {
    points[i] = {winners[i].point, winners[i].dimension, mesh_.vertex(winners[i].tet, 0)};
  });
  const std::uint32_t before = mesh_.vertex_count();
  std::vector<VertexId> made(points.size());
  execution_.insert(points, stamp_, made);
  round.inserted = mesh_.vertex_count() - before;
  // Later on, what is taken out could be asked for again, and again.
  constexpr int kRoundsWithRemoval = 12;
  const std::vector<VertexId> crowded =
      rounds_++ < kRoundsWithRemoval ? crowding(made, winners) : std::vector<VertexId>();
  execution_.remove(crowded, stamp_);
  round.removed = crowded.size();
  has_changed_ = round.inserted + round.removed > 0;
  round.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return round;
}

}  // namespace lumesh::delaunay
