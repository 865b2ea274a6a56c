#pragma once
/// @file The voxels of an image that planes cut.

#include <span>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::centerline {

/// The section at which a plane cuts a vessel.
struct CutSection {
  CutPlane plane;              ///< Unit normal, out of the vessel.
  std::vector<Index3> voxels;  ///< The last ones before the plane, ascending in memory order.
};

/// Both lists ascend in memory order.
struct CutVoxels {
  std::vector<Index3> inside;  ///< The object before all planes.
  /// Where vessels go on beyond the planes: what the image has there, and the section of a vessel that was
  /// cut off, carried straight on over its radius.
  std::vector<Index3> beyond;
  std::vector<CutSection> sections;
  std::vector<CutPlane> planes;  ///< The planes given, with unit normals.
};

/// @param cuts  Planes as ImageDomainOptions has them. Cost: linear in the voxels of the object times the
/// planes. Threads: parallel, same result for every thread count.
[[nodiscard]] CutVoxels voxels_before(const LabelImage& image, std::span<const CutPlane> cuts);

}  // namespace lumesh::centerline
