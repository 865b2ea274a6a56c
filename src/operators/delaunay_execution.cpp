#include "lumesh/operators/delaunay_execution.hpp"

#include <algorithm>

#include "execution_parts.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/published.hpp"
#include "lumesh/parallel/word_lock.hpp"

namespace lumesh::operators {
namespace {

constexpr int kKnownCells = 64;  // Of the grid of known vertices, along each axis.

/// Evenly spread over 32 bits; the same for the same place.
std::uint32_t scattered(std::size_t index) {
  std::uint64_t x = (index + 1) * 0x9E3779B97F4A7C15ull;
  x = (x ^ x >> 31) * 0xBF58476D1CE4E5B9ull;
  return static_cast<std::uint32_t>((x ^ x >> 29) >> 32);
}

/// The round of each point: a share of 1 - 1/8 in the last one, the same of the rest in the one before, until
/// few are left.
int round_of(std::size_t index, int last) {
  int round = last;
  for (std::uint32_t bits = scattered(index); round > 0 && (bits & 7u) == 0; bits >>= 3) --round;
  return round;
}

std::size_t bucket_size(std::size_t items) {
  constexpr std::size_t kMin = 16, kMax = 512, kBuckets = 2000;
  return std::clamp(items / kBuckets, kMin, kMax);
}

}  // namespace

DelaunayExecution::DelaunayExecution(TetMesh& mesh, const parallel::TeamOptions& team)
    : mesh_(mesh), team_(team), known_(kKnownCells * kKnownCells * kKnownCells, VertexId::kNone) {
  share_slots(mesh, team_.size());
  if (team_.size() == 1) {
    alone_.emplace_back(mesh, NoLock(), 0);
    return;
  }
  for (int thread = 0; thread < team_.size(); ++thread)
    kernels_.emplace_back(mesh, SpeculativeLock(mesh, static_cast<std::uint32_t>(thread) + 1), thread);
}

/// @param attempt  attempt(kernel, item): false if it must be made again.
template <class Lock, class Attempt>
void DelaunayExecution::run_buckets(std::vector<DelaunayKernel<Lock>>& kernels,
                                    std::vector<std::uint32_t>& items, std::uint32_t stamp,
                                    const Attempt& attempt) {
  constexpr std::size_t kWorthATeam = 128;
  if (team_.size() == 1 || items.size() < kWorthATeam) {
    kernels[0].begin_run(stamp);
    VertexId last;
    for (const std::uint32_t item : items) {
      const bool is_done = attempt(kernels[0], item, last);
      LUMESH_DEBUG_ASSERT(is_done);  // Nobody else is there.
      (void)is_done;
    }
    return;
  }
  run_in_buckets(team_, items, bucket_size(items.size()), [&](std::size_t thread) {
    DelaunayKernel<Lock>& kernel = kernels[thread];
    kernel.begin_run(stamp);
    return [&, last = VertexId()](std::uint32_t item) mutable { return attempt(kernel, item, last); };
  });
}

std::uint32_t& DelaunayExecution::known_near(const Vec3& point) {
  const Vec3 at = (point - box_.min()).cwiseQuotient(box_.sizes()) * kKnownCells;
  std::size_t cell = 0;
  for (int axis = 2; axis >= 0; --axis)
    cell = cell * kKnownCells +
           static_cast<std::size_t>(std::clamp(static_cast<int>(at[axis]), 0, kKnownCells - 1));
  return known_[cell];
}

template <class Lock>
void DelaunayExecution::insert_in_order(std::vector<DelaunayKernel<Lock>>& kernels,
                                        std::span<const NewVertex> points,
                                        std::span<const std::uint32_t> order, std::uint32_t stamp,
                                        std::span<VertexId> vertices) {
  std::vector<std::uint32_t> items(order.begin(), order.end());
  run_buckets(kernels, items, stamp, [&](DelaunayKernel<Lock>& kernel, std::uint32_t item, VertexId& last) {
    const NewVertex& one = points[item];
    VertexId near = one.near.valid() ? one.near : last;
    if (!near.valid()) near = VertexId(parallel::load_published(known_near(one.point)));
    if (!near.valid() || !mesh_.alive(near)) near = VertexId(0);
    const auto [outcome, vertex] = kernel.insert(one.point, one.dimension, near);
    if (outcome == Outcome::kContended) return false;
    last = vertex;
    parallel::publish(known_near(one.point), vertex.value);
    if (!vertices.empty()) vertices[item] = vertex;
    return true;
  });
}

void DelaunayExecution::insert(std::span<const NewVertex> points, std::uint32_t stamp,
                               std::span<VertexId> vertices) {
  if (points.empty()) return;
  constexpr std::size_t kFew = 1000;
  int rounds = 1;
  for (std::size_t first = points.size(); first > std::max<std::size_t>(kFew, mesh_.vertex_count());
       first /= 8)
    ++rounds;
  std::vector<Vec3> places(points.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) { places[i] = points[i].point; });
  box_ = bounding_box(places);
  box_.max() += Vec3::Constant(1e-9 * box_.sizes().norm() + 1e-300);
  const std::vector<std::uint32_t> along_curve = hilbert_order(places);
  for (int round = 0; round < rounds; ++round) {
    const std::vector<std::uint32_t> order = parallel::collect<std::uint32_t>(
        along_curve.size(), [&](std::size_t i, std::vector<std::uint32_t>& out) {
          if (round_of(along_curve[i], rounds - 1) == round) out.push_back(along_curve[i]);
        });
    if (team_.size() == 1)
      insert_in_order(alone_, points, order, stamp, vertices);
    else
      insert_in_order(kernels_, points, order, stamp, vertices);
  }
}

void DelaunayExecution::remove(std::span<const VertexId> vertices, std::uint32_t stamp) {
  std::vector<std::uint32_t> items(vertices.size());
  parallel::for_each_index(items.size(), [&](std::size_t i) { items[i] = vertices[i].value; });
  const auto take_out = [](auto& kernel, std::uint32_t item, VertexId& /*last*/) {
    return kernel.remove(VertexId(item)) == Outcome::kApplied;
  };
  if (team_.size() == 1)
    run_buckets(alone_, items, stamp, take_out);
  else
    run_buckets(kernels_, items, stamp, take_out);
}

}  // namespace lumesh::operators
