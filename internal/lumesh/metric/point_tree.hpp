#pragma once
/// @file The nearest of many points.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

/// The points in order of x, y, z, each once: what is made of them does not depend on the order they came in.
/// @throws Error{kBadInput} that names a point which is not finite.
[[nodiscard]] std::vector<Vec3> distinct_by_place(std::span<const Vec3> points);

/// A k-d tree. Threads: const members may run at the same time.
class PointTree {
 public:
  /// @param points  Must stay as they are while the tree lives.
  explicit PointTree(std::span<const Vec3> points);
  PointTree(const PointTree&) = delete;
  PointTree& operator=(const PointTree&) = delete;
  ~PointTree();

  /// Indices of the `out.size()` points nearest to `place`, nearest first; of points as near as one another
  /// those of the lower indices. There must be as many points.
  void nearest(const Vec3& place, std::span<std::uint32_t> out) const;

  /// Mean distance to the k points nearest to `place`, 1 <= k; there must be as many points. Cost: about 3 us
  /// for k = 30.
  [[nodiscard]] double mean_distance(const Vec3& place, std::size_t k) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

/// @throws Error{kBadInput} if there are fewer than k points.
void require_as_many(std::size_t count, std::size_t k);

/// The median distance from a point to its nearest one; at least two points, all different.
[[nodiscard]] double median_spacing(std::span<const Vec3> points, const PointTree& tree);

/// @throws Error{kBadInput} that says both boxes, unless a point lies about the places: within one diagonal
/// of their box. Else unit or frame are probably wrong.
void require_near_points(std::span<const Vec3> places, std::span<const Vec3> points);

/// Calls work(i) for all places in parallel, those near each other one after the other.
/// @param make_work  Gives the work of a block of places, with its own memory.
template <class MakeWork>
void for_each_along_curve(std::span<const Vec3> places, const MakeWork& make_work) {
  constexpr std::size_t kPlacesAtOnce = 1024;
  const std::vector<std::uint32_t> order = hilbert_order(places);
  parallel::for_each_block(places.size(), kPlacesAtOnce,
                           [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
                             auto work = make_work();
                             for (std::size_t i = begin; i < end; ++i) work(order[i]);
                           });
}

}  // namespace lumesh::metric
