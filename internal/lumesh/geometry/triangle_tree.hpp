#pragma once
/// @file A tree of triangles: the nearest point on them, those in a box, pairs of them that are close
/// together.

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/box_heap.hpp"

namespace lumesh {

/// A balanced tree of boxes over triangles. It copies what it needs: the input may go after construction.
/// Memory: about 110 bytes per triangle. Threads: queries are const and may run at the same time.
class TriangleTree {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  struct Nearest {
    double distance = std::numeric_limits<double>::infinity();  ///< In the unit of the points.
    Vec3 point = Vec3::Zero();
    std::uint32_t triangle = kNone;  ///< Index in the input; the lowest among equally near ones.
  };

  /// Builds in parallel, the same tree for every thread count. Cost: O(n log n), about 20 ms for 100k
  /// triangles.
  /// @throws Error{kBadInput} if a triangle names a point that is not there or has a coordinate that is not
  /// finite.
  TriangleTree(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles);

  /// Nearest point of any triangle to `query` (finite) no farther than `upper_bound`; `triangle` is kNone if
  /// there is none. A good bound, such as the distance of a neighbour's answer, saves time. Cost: about 1 us
  /// near the surface; far from it a slack helps: the answer may then be one that is 1 / (1 - slack) times as
  /// far as the nearest, slack in [0, 1).
  [[nodiscard]] Nearest nearest(const Vec3& query,
                                double upper_bound = std::numeric_limits<double>::infinity(),
                                double relative_slack = 0) const;

  /// The triangles whose own boxes along the axes meet the box [low, high], as indices in the input,
  /// ascending.
  [[nodiscard]] std::vector<std::uint32_t> overlapping(const Vec3& low, const Vec3& high) const;

  /// The pairs of triangles whose own boxes meet and for which is_wanted(a, b) holds, as indices in the
  /// input: a < b in each, ascending. Threads: is_wanted is asked from several at once. Cost: about 0.3 us
  /// per triangle, and what is_wanted costs.
  [[nodiscard]] std::vector<std::array<std::uint32_t, 2>> pairs(
      const std::function<bool(std::uint32_t, std::uint32_t)>& is_wanted) const;

 private:
  using Box = BoxHeap::Box;
  struct Item;     // A triangle while the tree is being built.
  struct Builder;  // The recursive construction.

  [[nodiscard]] Box box_of_item(std::size_t item) const {
    Box box;
    for (const Vec3& corner : corners_[item]) box.extend(corner);
    return box;
  }

  BoxHeap heap_;
  std::vector<std::array<Vec3, 3>> corners_;  // In leaf order.
  std::vector<std::uint32_t> ids_;            // Input index of each.
};

}  // namespace lumesh
