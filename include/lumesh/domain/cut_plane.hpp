#pragma once
/// @file Planes that cut the object off, and what they leave of an image.

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

struct CarriedSection;
class LabelImage;

/// A plane that cuts the object off: what lies on the side of the normal is removed. With a radius and a
/// depth it removes only what of the object lies in the cylinder that stands on the plane, so that it cuts
/// one vessel.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Need not be of unit length but with a radius, must not be zero.
  double radius_mm = std::numeric_limits<double>::infinity();  ///< Around the point.
  double depth_mm = std::numeric_limits<double>::infinity();   ///< From the plane along the normal.
  /// Instead of the cylinder, where an extended vessel ends: what has been carried there.
  std::shared_ptr<const CarriedSection> section = nullptr;
  /// Names that the openings in it have, by falling area of each label; others are named by their areas.
  std::vector<std::pair<Label, std::string>> names = {};

  [[nodiscard]] bool is_bounded() const { return radius_mm < std::numeric_limits<double>::infinity(); }
  /// How far a point is beyond the plane; in mm where the normal is of unit length.
  [[nodiscard]] double height(const Vec3& x) const { return normal.dot(x - point_mm); }
  /// How deep a point is within what is removed; negative outside. The normal is of unit length.
  [[nodiscard]] double beyond_mm(const Vec3& x) const;
};

/// The point, or one on the planes that it lies beyond; their normals are of unit length.
[[nodiscard]] Vec3 nearest_within(std::span<const CutPlane> planes, Vec3 point_mm);

/// Voxels of each label (in the order of image.values(), 0 for the background) on the kept side of all
/// planes. Voxels that a plane passes through count by their share, taken as linear in the plane's place.
[[nodiscard]] std::vector<double> count_kept_voxels(const LabelImage& image,
                                                    std::span<const CutPlane> planes);

}  // namespace lumesh
