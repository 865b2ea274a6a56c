#include "refinement.hpp"

#include <algorithm>
#include <chrono>
#include <tuple>

#include "conflicts.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"

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

std::vector<TetId> Refinement::fresh_tets() const {
  return parallel::collect<TetId>(
      mesh_.tet_slots(),
      [&](std::size_t i, std::vector<TetId>& out) {
        if (const TetId t(static_cast<std::uint32_t>(i)); mesh_.stamp(t) == stamp_) out.push_back(t);
      },
      16384);
}

void Refinement::find_materials(std::span<const TetId> fresh) {
  parallel::for_each_index(
      fresh.size(),
      [&](std::size_t i) { mesh_.set_label(fresh[i], static_cast<Label>(rules_.material_of(fresh[i]))); },
      256);
}

std::vector<Wish> Refinement::wishes_of(std::span<const TetId> fresh) const {
  return parallel::collect<Wish>(
      fresh.size(),
      [&](std::size_t i, std::vector<Wish>& out) {
        const TetId t = fresh[i];
        const Circumsphere sphere = circumsphere(mesh_, t);
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

std::vector<Wish> Refinement::granted(std::vector<Wish> wishes) {
  parallel::sort(wishes.begin(), wishes.end(), is_more_urgent);
  claims_.resize(mesh_.tet_slots(), 0);
  std::vector<std::vector<TetId>> conflicts(wishes.size());
  parallel::for_each_block(wishes.size(), 64, [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
    ConflictFinder finder;
    for (std::size_t i = begin; i < end; ++i) {
      const auto found = finder.find(mesh_, wishes[i].point, wishes[i].tet);
      conflicts[i].assign(found.begin(), found.end());
      for (const TetId t : found) parallel::raise_to(claims_[t.value], wishes.size() - i);
    }
  });
  auto won = parallel::collect<Wish>(wishes.size(), [&](std::size_t i, std::vector<Wish>& out) {
    const bool is_free = std::all_of(conflicts[i].begin(), conflicts[i].end(),
                                     [&](TetId t) { return claims_[t.value] == wishes.size() - i; });
    if (conflicts[i].empty()) return;
    if (is_free) out.push_back(wishes[i]);
  });
  parallel::for_each_index(wishes.size(), [&](std::size_t i) {
    for (const TetId t : conflicts[i])
      if (claims_[t.value] == wishes.size() - i) claims_[t.value] = 0;
    // Looked at again in the next round; if it is gone by then, so is the stamp.
    if (!conflicts[i].empty()) mesh_.set_stamp(wishes[i].tet, stamp_ + 1);
  });
  return won;
}

/// Inner vertices too near to new ones of a surface (R6).
std::vector<VertexId> Refinement::crowding(std::span<const VertexId> made) const {
  auto found = parallel::collect_blocks<VertexId>(
      made.size(), 64, [&](std::size_t begin, std::size_t end, std::vector<VertexId>& out) {
        VertexStar star;
        for (std::size_t i = begin; i < end; ++i) {
          const VertexId v = made[i];
          if (!v.valid() || mesh_.dimension(v) == VertexDimension::kVolume) continue;
          constexpr double kNear = 0.5;
          const double least = kNear * spacing_.delta_mm();
          for (const TetId t : star.gather(mesh_, v))
            for (const std::uint32_t w : mesh_.tet(t))
              if (w >= 4 && mesh_.dimension(VertexId(w)) == VertexDimension::kVolume &&
                  (mesh_.point(VertexId(w)) - mesh_.point(v)).squaredNorm() < least * least)
                out.push_back(VertexId(w));
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
  find_materials(fresh);
  std::vector<Wish> wishes = wishes_of(fresh);
  round.tets_looked_at = fresh.size();
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
  const std::vector<VertexId> crowded = crowding(made);
  execution_.remove(crowded, stamp_);
  round.removed = crowded.size();
  round.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return round;
}

}  // namespace lumesh::delaunay
