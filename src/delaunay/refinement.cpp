#include "refinement.hpp"

#include <algorithm>
#include <chrono>

#include "bad_faces.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/metric/point_tree.hpp"
#include "lumesh/parallel/loops.hpp"
#include "thinning.hpp"
#include "topology.hpp"

namespace lumesh::delaunay {
namespace {

constexpr std::size_t kBlock = 1024;

}  // namespace

void Refinement::insert_seeds(const Seeds& seeds, std::span<const std::uint32_t> boundary) {
  std::vector<operators::DelaunayExecution::NewVertex> points(boundary.size() + seeds.inner.size() +
                                                              seeds.outer.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) {
    if (i < boundary.size()) {
      const BoundaryCandidate& one = seeds.boundary[boundary[i]];
      points[i] = {one.point, dimension_of(one.materials), {}};
    } else {
      const std::size_t rest = i - boundary.size();
      points[i] = {rest < seeds.inner.size() ? seeds.inner[rest] : seeds.outer[rest - seeds.inner.size()],
                   VertexDimension::kVolume,
                   {}};
    }
  });
  execution_.insert(points, stamp_);
}

std::size_t Refinement::complete(std::span<const BoundaryCandidate> candidates) {
  if (candidates.empty()) return 0;
  constexpr double kFar = 1.25;  // Of the distance of candidates. A little more than R1 allows is left to it.
  std::vector<Vec3> known;
  for (std::uint32_t v = 4; v < mesh_.vertex_slots(); ++v)
    if (mesh_.alive(VertexId(v)) && mesh_.dimension(VertexId(v)) != VertexDimension::kVolume)
      known.push_back(mesh_.point(VertexId(v)));
  const metric::PointTree tree(known);
  const auto missing = parallel::collect<BoundaryCandidate>(
      candidates.size(), [&](std::size_t i, std::vector<BoundaryCandidate>& out) {
        const BoundaryCandidate& one = candidates[i];
        if (known.empty() || tree.mean_distance(one.point, 1) > kFar * one.spacing) out.push_back(one);
      });
  std::vector<operators::DelaunayExecution::NewVertex> points;
  for (const std::uint32_t i : poisson_disk_subset(missing))
    points.push_back({missing[i].point, dimension_of(missing[i].materials), {}});
  execution_.insert(points, stamp_);
  has_changed_ |= !points.empty();
  return points.size();
}

std::vector<TetId> Refinement::fresh_tets() const {
  return parallel::collect<TetId>(mesh_.tet_slots(), 16384, [&](std::size_t i, std::vector<TetId>& out) {
    if (const TetId t(static_cast<std::uint32_t>(i)); mesh_.stamp(t) == stamp_) out.push_back(t);
  });
}

std::vector<Circumsphere> Refinement::find_materials(std::span<const TetId> fresh) {
  std::vector<Circumsphere> spheres(fresh.size());
  parallel::for_each_index(fresh.size(), 256, [&](std::size_t i) {
    spheres[i] = circumsphere(mesh_, fresh[i]);
    mesh_.set_label(fresh[i], static_cast<Label>(rules_.material_at(spheres[i])));
  });
  return spheres;
}

std::vector<Candidate> Refinement::candidates_for(std::span<const TetId> fresh,
                                                  std::span<const Circumsphere> spheres) const {
  return parallel::collect<Candidate>(fresh.size(), kBlock, [&](std::size_t i, std::vector<Candidate>& out) {
    const TetId t = fresh[i];
    const Circumsphere& sphere = spheres[i];
    for (int f = 0; f < 4; ++f) {
      if (!rules_.is_boundary(t, f)) continue;
      const TetId other = mesh_.link(t, f).tet();
      // Once for each face, from the same side whatever the numbers are.
      if (mesh_.stamp(other) == stamp_ && mesh_.label(other) < mesh_.label(t)) continue;
      if (const auto candidate = rules_.candidate_for_face(t, f, sphere)) out.push_back(*candidate);
    }
    if (const auto candidate = rules_.candidate_for_crossed_opening(t, sphere)) out.push_back(*candidate);
    if (const auto candidate = rules_.candidate_for_tet(t, sphere)) out.push_back(*candidate);
  });
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
  sort_unique(suspects);
  std::erase_if(*pinched_,
                [&](VertexId v) { return !mesh_.alive(v) || std::ranges::binary_search(suspects, v); });
  std::vector<VertexId> found = pinched_among(mesh_, spacing_.domain(), suspects);
  pinched_->insert(pinched_->end(), found.begin(), found.end());
  return found;
}

std::vector<Candidate> Refinement::topology_candidates(std::span<const VertexId> pinched) const {
  return parallel::collect_blocks<Candidate>(
      pinched.size(), 16, [&](std::size_t begin, std::size_t end, std::vector<Candidate>& out) {
        VertexStar star;
        for (std::size_t i = begin; i < end; ++i) {
          std::optional<Candidate> best;
          for (const TetId t : star.gather(mesh_, pinched[i])) {
            const Circumsphere sphere = circumsphere(mesh_, t);
            for (int f = 0; f < 4; ++f) {
              if (mesh_.vertex(t, f) == pinched[i] || !rules_.is_boundary(t, f)) continue;
              // From the same side whatever the numbers are: the other tetrahedron is around the vertex, too.
              if (mesh_.label(mesh_.link(t, f).tet()) < mesh_.label(t)) continue;
              const auto candidate = rules_.centre_of_face(t, f, sphere);
              if (candidate && (!best || has_higher_priority(*candidate, *best))) best = candidate;
            }
          }
          if (best) out.push_back(*best);
        }
      });
}

/// Inner vertices too near to new ones of a surface (R6), and those of surfaces to new ones of curves.
std::vector<VertexId> Refinement::encroaching(std::span<const VertexId> made,
                                              std::span<const Candidate> candidates) const {
  auto found = parallel::collect_blocks<VertexId>(
      made.size(), 64, [&](std::size_t begin, std::size_t end, std::vector<VertexId>& out) {
        VertexStar star;
        for (std::size_t i = begin; i < end; ++i) {
          const VertexId v = made[i];
          if (!v.valid() || mesh_.dimension(v) == VertexDimension::kVolume) continue;
          constexpr double kNear = 0.5, kNearCurve = 0.3;
          const auto encroaches = [&](VertexId w) {
            const VertexDimension dimension = mesh_.dimension(w);
            if (dimension <= VertexDimension::kCurve || dimension <= mesh_.dimension(v)) return false;
            if (spacing_.domain().is_fixed(mesh_.point(w))) return false;
            const double min_distance =
                (dimension == VertexDimension::kVolume ? kNear : kNearCurve) * candidates[i].spacing;
            return (mesh_.point(w) - mesh_.point(v)).squaredNorm() < min_distance * min_distance;
          };
          for (const TetId t : star.gather(mesh_, v))
            for (const std::uint32_t w : mesh_.tet(t))
              if (w >= 4 && encroaches(VertexId(w))) out.emplace_back(w);
        }
      });
  parallel::sort_unique(found);
  return found;
}

std::size_t Refinement::clear() {
  constexpr double kMinAngleDeg = 25;
  constexpr int kMaxClearings = 8;  // Some come back, whatever is taken out.
  if (clearings_ == kMaxClearings) return 0;
  std::vector<VertexId> gone =
      vertices_of_bad_faces(mesh_, rules_, spacing_, kMinAngleDeg, clearings_++ % 2 == 0);
  for (const VertexId v : pinched())
    if (v.value >= 4 && mesh_.dimension(v) == VertexDimension::kSurface &&
        !spacing_.domain().is_fixed(mesh_.point(v)))
      gone.push_back(v);
  sort_unique(gone);
  execution_.remove(gone, stamp_);
  has_changed_ |= !gone.empty();
  return gone.size();
}

DelaunayRound Refinement::run_round() {
  const auto start = std::chrono::steady_clock::now();
  DelaunayRound round;
  const std::vector<TetId> fresh = fresh_tets();
  const std::vector<Circumsphere> spheres = find_materials(fresh);
  std::vector<Candidate> candidates = candidates_for(fresh, spheres);
  round.tets_looked_at = fresh.size();
  // Shapes first: their points repair most pinched vertices.
  constexpr std::uint32_t kFew = 1000;  // One of so many vertices.
  const auto of_surfaces = std::ranges::count_if(
      candidates, [](const Candidate& w) { return w.dimension != VertexDimension::kVolume; });
  if (pinched_ || of_surfaces <= static_cast<std::ptrdiff_t>(mesh_.vertex_count() / kFew)) {
    const std::vector<Candidate> more = topology_candidates(newly_pinched(fresh));
    candidates.insert(candidates.end(), more.begin(), more.end());
    round.topology_candidates = more.size();
  }
  for (const Candidate& candidate : candidates)
    ++(candidate.dimension == VertexDimension::kVolume ? round.volume_candidates : round.surface_candidates);
  const std::vector<Candidate> winners = independent_set_.select(mesh_, std::move(candidates), stamp_ + 1);
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
  const std::vector<VertexId> encroaching_vertices =
      rounds_++ < kRoundsWithRemoval ? encroaching(made, winners) : std::vector<VertexId>();
  execution_.remove(encroaching_vertices, stamp_);
  round.removed = encroaching_vertices.size();
  has_changed_ = round.inserted + round.removed > 0;
  round.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return round;
}

}  // namespace lumesh::delaunay
