#pragma once
/// @file A closed surface in regions, and the curves and corners where those meet.

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "closed_surface.hpp"
#include "lumesh/geometry/triangle_tree.hpp"

namespace lumesh::surfaces {

/// Parts of a surface that no kept edge divides, by falling area.
struct FeatureRegions {
  std::vector<std::uint32_t> of_triangle;
  std::vector<std::int32_t> patches;  ///< Of each region.
  std::vector<double> areas_mm2;

  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(patches.size()); }
};

/// Kept are edges between patches, and those whose normals differ by more than the angle, but not around
/// specks of a few triangles.
[[nodiscard]] FeatureRegions find_regions(const ClosedSurface& surface, double feature_angle_deg);

/// The regions, with each of these sets of triangles, of one patch each, as one region.
[[nodiscard]] FeatureRegions with_regions(const ClosedSurface& surface, FeatureRegions regions,
                                          std::span<const std::vector<std::uint32_t>> sets);

/// The edges between every two regions, and the points where more than two meet.
class RegionBorders {
 public:
  RegionBorders(const ClosedSurface& surface, const FeatureRegions& regions);

  /// Nearest place within a distance where the regions meet: on a curve for two, a point for more.
  /// @param regions  At least two, ascending.
  [[nodiscard]] std::optional<Vec3> nearest(const Vec3& x, std::span<const std::uint32_t> regions,
                                            double reach) const;

 private:
  struct Corner {
    Vec3 point;
    std::vector<std::uint32_t> regions;  // Ascending.
  };
  void find_curves(const ClosedSurface& surface, const FeatureRegions& regions);
  void find_corners(const ClosedSurface& surface, const FeatureRegions& regions);

  std::map<std::pair<std::uint32_t, std::uint32_t>, TriangleTree> curves_;  // Triangles that are edges.
  std::vector<Corner> corners_;
  std::vector<std::vector<std::uint32_t>> corners_of_;  // Of each region, into corners_.
};

}  // namespace lumesh::surfaces
