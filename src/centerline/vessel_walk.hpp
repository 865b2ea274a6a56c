#pragma once
/// @file A walk along a vessel, and what can be carried along with it.

#include <optional>
#include <vector>

#include "lumen.hpp"
#include "voxel_paths.hpp"
#include "voxel_tree.hpp"

namespace lumesh::centerline {

/// Places along paths from the tree's root through a voxel of theirs to the end of its path, and where one
/// ends at an opening that is cut obliquely, straight on to the last place inside.
class VesselWalk {
 public:
  /// @param path  The number of the path that `voxel` is on.
  VesselWalk(const Lumen& lumen, const PathTree& tree, const std::vector<VoxelPath>& paths, std::size_t path,
             std::uint32_t voxel);

  /// Starts at the place nearest to a position.
  void start_beside(const Vec3& position);
  [[nodiscard]] Vec3 start() const { return places_[start_]; }
  /// The unit direction of the walk at the start.
  [[nodiscard]] Vec3 direction() const { return direction(start_); }

  /// Carries a straight way that begins at the start along the walk, turning as it does, and says how far it
  /// came: up to `far_mm` or to an end of the vessel.
  /// @param step  -1 towards the root, 1 away from it.
  /// @return      Nothing where the way leaves the lumen.
  [[nodiscard]] std::optional<double> carried_mm(const Vec3& across, double far_mm, int step) const;

  /// Whether all of a straight way is in the lumen, but for its beginning.
  [[nodiscard]] bool is_in_lumen(const Vec3& from, const Vec3& way) const;

 private:
  void go_straight_on();
  [[nodiscard]] Vec3 direction(std::size_t n) const;
  [[nodiscard]] bool is_past_opening(std::size_t n, const Vec3& across) const;

  const Lumen& lumen_;
  std::vector<Vec3> places_;
  std::vector<double> walls_mm_;
  std::size_t start_ = 0;
};

}  // namespace lumesh::centerline
