#pragma once
/// @file Projection onto a closed surface: the closest point, its side and its region.

#include <cstdint>
#include <limits>
#include <vector>

#include "closed_surface.hpp"
#include "feature_regions.hpp"
#include "lumesh/geometry/triangle_tree.hpp"

namespace lumesh::surfaces {

/// The place of a surface nearest to a point.
struct ClosestPoint {
  double distance = std::numeric_limits<double>::infinity();
  Vec3 point = Vec3::Zero();
  std::uint32_t triangle = TriangleTree::kNone;  ///< kNone: nothing as near as was asked.
};

/// Const calls from any thread. Keeps references to what it is made from.
class SurfaceProjector {
 public:
  SurfaceProjector(const ClosedSurface& surface, const FeatureRegions& regions);

  [[nodiscard]] ClosestPoint nearest(const Vec3& x) const { return closest_of(tree_.nearest(x)); }
  /// The same, quicker if `guess` is a triangle near by.
  [[nodiscard]] ClosestPoint nearest(const Vec3& x, std::uint32_t guess) const;
  /// Nearly the nearest: not farther than the nearest by more than the share of itself.
  [[nodiscard]] ClosestPoint nearly_nearest(const Vec3& x, std::uint32_t guess, double relative_slack) const;
  /// Distance to one triangle.
  [[nodiscard]] double distance_to_triangle(const Vec3& x, std::uint32_t triangle) const {
    return closest_on(x, triangle).distance;
  }
  /// The place of one region, no farther than `reach`.
  [[nodiscard]] ClosestPoint nearest_of_region(const Vec3& x, std::uint32_t region,
                                               double reach = std::numeric_limits<double>::infinity()) const;

  /// By the normal at the closest point; on edges and points the mean of the triangles there, weighted by
  /// angles, tells the sides apart. Source: Baerentzen and Aanaes 2005, doi:10.1109/TVCG.2005.49.
  [[nodiscard]] bool is_inside(const Vec3& x, const ClosestPoint& closest) const;
  /// The region that x, outside, belongs to. Where the closest point is on an edge or a point between
  /// several, it is the one over whose plane x is highest.
  [[nodiscard]] std::uint32_t region_over(const Vec3& x, const ClosestPoint& closest) const;
  [[nodiscard]] const ClosedSurface& surface() const { return surface_; }

 private:
  [[nodiscard]] ClosestPoint closest_on(const Vec3& x, std::uint32_t triangle) const;
  [[nodiscard]] static ClosestPoint closest_of(const TriangleTree::Nearest& found) {
    return {found.distance, found.point, found.triangle};
  }
  void find_point_normals();
  void plant_region_trees();

  const ClosedSurface& surface_;
  const FeatureRegions& regions_;
  TriangleTree tree_;
  std::vector<Vec3> point_normals_;  // Not of unit length.
  struct RegionTree {
    TriangleTree tree;
    std::vector<std::uint32_t> triangles;
    Box3 box;
  };
  std::vector<RegionTree> region_trees_;  // None if there is one region only.
};

}  // namespace lumesh::surfaces
