#pragma once
/// @file Which side of the cut planes a point is on.

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <vector>

#include "lumesh/quality/hausdorff.hpp"

namespace lumesh::quality {

/// Planes with unit normals, and the tolerance that goes with the voxel size.
class CutPlanes {
 public:
  CutPlanes(std::span<const CutPlane> planes, double voxel_size_mm)
      : planes_(planes.begin(), planes.end()), tolerance_mm_(0.05 * voxel_size_mm) {
    for (CutPlane& plane : planes_) plane.normal.normalize();
  }
  [[nodiscard]] bool none() const { return planes_.empty(); }
  /// True if the point was cut off.
  [[nodiscard]] bool beyond(const Vec3& p) const {
    return std::ranges::any_of(planes_, [&](const CutPlane& plane) { return plane.beyond_mm(p) > 0; });
  }
  /// True if all of the points lie on the same plane, as the corners of a cap do.
  [[nodiscard]] bool contain(std::initializer_list<Vec3> points) const {
    return std::ranges::any_of(planes_, [&](const CutPlane& plane) {
      return std::ranges::all_of(points,
                                 [&](const Vec3& p) { return std::abs(plane.beyond_mm(p)) < tolerance_mm_; });
    });
  }

 private:
  std::vector<CutPlane> planes_;
  double tolerance_mm_;
};

}  // namespace lumesh::quality
