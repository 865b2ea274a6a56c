#pragma once
/// @file What is known in advance of cubes of space around a surface.

#include <cstdint>
#include <vector>

#include "surface_projector.hpp"

namespace lumesh::surfaces {

/// A cube whose middle was measured.
struct DistanceCell {
  static constexpr std::uint32_t kMixed = ~0u;

  float distance = 0;             ///< Of the middle; rounded down, < 0 outside.
  std::uint32_t triangle = 0;     ///< Nearest to the middle.
  std::uint32_t first_child = 0;  ///< Of eight; 0: none.
  std::uint32_t region = kMixed;  ///< Outside, that of the whole cube.
};

/// Cubes around a closed surface, small near it. Const calls from any thread.
class DistanceOctree {
 public:
  /// Parallel inside, the same for every thread count.
  /// @param min_size  Cubes are not divided to less than about this.
  DistanceOctree(const SurfaceProjector& projector, std::uint32_t region_count, const Box3& box,
                 double min_size);

  struct Found {
    const DistanceCell* cell = nullptr;  ///< None outside the largest cube, where nothing of the surface is.
    double from_middle = 0;              ///< Distance to the cube's middle.
    double half_diagonal = 0;

    /// The least distance to the surface; 0 or less if it may be here.
    [[nodiscard]] double min_distance() const { return std::abs(double{cell->distance}) - from_middle; }
    /// Whether nothing of the surface is in the whole cube.
    [[nodiscard]] bool is_free() const { return std::abs(double{cell->distance}) >= half_diagonal; }
  };
  [[nodiscard]] Found find(const Vec3& x) const;
  [[nodiscard]] std::size_t cell_count() const { return cells_.size(); }

 private:
  struct Place {
    std::uint32_t cell;
    Vec3 middle;
  };
  /// Gives cubes that join without the surface between them one side: outside where they reach the border of
  /// the largest, else that of most of their volume. Where a surface crosses itself, normals at the closest
  /// point tell the wrong side in cones that have no end.
  void settle_sides();
  /// Calls use(cell, middle, half_size) for the cubes that are not divided.
  template <class Use>
  void for_each_leaf(const Use& use) const;
  /// @param parent  At another middle; null for the first.
  [[nodiscard]] static DistanceCell measured(const SurfaceProjector& projector, std::uint32_t region_count,
                                             const Place& place, double half_diagonal, const Found* parent);

  Vec3 middle_ = Vec3::Zero();
  double half_size_ = 0;
  std::vector<DistanceCell> cells_;
};

}  // namespace lumesh::surfaces
