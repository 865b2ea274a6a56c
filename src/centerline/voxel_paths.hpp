#pragma once
/// @file Shortest paths through voxels.

#include <functional>
#include <vector>

#include "lumen.hpp"

namespace lumesh::centerline {

/// Neighbours of a voxel inside the lumen that a walk through faces within the same 2 x 2 x 2 voxels can
/// reach, so that no path slips through where vessels touch at an edge. Calls use(number, length in mm).
class Steps {
 public:
  explicit Steps(const Lumen& lumen);

  template <class Use>
  void for_each(std::uint32_t from, const Use& use) const {
    const std::array<std::uint32_t, 27> ids = lumen_.around(from);
    // A ball of this size holds all of them.
    const bool free = lumen_.wall_mm(from) > 2 * lengths_.back();
    for (int n = 0; n < 27; ++n) {
      const auto at = static_cast<std::size_t>(n);
      if (n != kSelf && (free || (ids[at] != kNoVoxel && reachable(ids, n))) && ids[at] != kNoVoxel)
        use(ids[at], lengths_[at]);
    }
  }

 private:
  static constexpr int kSelf = 13;
  [[nodiscard]] static bool reachable(const std::array<std::uint32_t, 27>& ids, int n);

  const Lumen& lumen_;
  std::array<double, 27> lengths_;
};

/// Shortest paths from one voxel to all others by a cost that keeps them in the middle: length over the
/// square of the distance to the wall.
struct PathTree {
  std::uint32_t root = kNoVoxel;
  std::vector<std::uint32_t> before;  ///< Next voxel towards the root; the root itself at the root.
  std::vector<float> length_mm;       ///< Along the path.
  std::vector<float> room;            ///< Length times distance to the wall, summed along the path, mm^2.
};

enum class PathCost : std::uint8_t { kLength, kCentred };

[[nodiscard]] PathTree shortest_paths(const Lumen& lumen, const Steps& steps, std::uint32_t root,
                                      PathCost cost);

/// A path from `from` to the cheapest voxel that `wanted` takes, among those within `reach_mm` along the way;
/// empty if there is none.
[[nodiscard]] std::vector<std::uint32_t> path_to_nearest(
    const Lumen& lumen, const Steps& steps, std::uint32_t from, double reach_mm,
    const std::function<bool(std::uint32_t, double)>& wanted);

}  // namespace lumesh::centerline
