#pragma once
/// @file Nearest triangles of points that come one after the other.

#include <limits>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {

/// A bound on the distance of the next point by that of the last one, a little widened for rounding.
[[nodiscard]] inline double bound_from(double last_distance, const Vec3& last, const Vec3& next) {
  return (last_distance + (next - last).norm()) * (1 + 1e-9) + 1e-12;
}

/// Distance to the nearest triangle for a run of points that are near each other.
class Nearby {
 public:
  explicit Nearby(const TriangleTree& tree) : tree_(tree) {}
  double distance(const Vec3& p) {
    TriangleTree::Nearest found = tree_.nearest(p, bound_from(last_distance_, last_, p));
    if (found.triangle == TriangleTree::kNone) found = tree_.nearest(p);
    last_ = p;
    last_distance_ = found.distance;
    return found.distance;
  }

 private:
  const TriangleTree& tree_;
  Vec3 last_ = Vec3::Zero();
  double last_distance_ = std::numeric_limits<double>::infinity();
};

/// Calls visit(nearby, i) for all i < count in parallel; consecutive ones shall be near each other.
template <class Visit>
void for_each_nearby(const TriangleTree& tree, std::size_t count, const Visit& visit) {
  constexpr std::size_t kBlock = 1024;
  parallel::for_each_block(count, kBlock, [&](std::size_t /*block*/, std::size_t begin, std::size_t end) {
    Nearby nearby(tree);
    for (std::size_t i = begin; i < end; ++i) visit(nearby, i);
  });
}

}  // namespace lumesh::quality
