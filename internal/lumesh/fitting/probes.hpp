#pragma once
/// @file Places of the domain's boundary at which the distance of the surface is measured.

#include <algorithm>
#include <array>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::fitting {

/// A place of the domain's boundary.
struct Probe {
  Vec3 position_mm;
  std::array<Material, 2> materials;  ///< On its two sides, ascending.
};

[[nodiscard]] inline std::array<Material, 2> ascending(Material a, Material b) {
  return {std::min(a, b), std::max(a, b)};
}

/// The places of the boundary next to the corners and centres of voxel faces between labels, or a label and
/// the background, on the kept side of cut planes; where no boundary is within 0.9 voxels, none is kept.
[[nodiscard]] std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain);

/// Probes within a radius of a place.
[[nodiscard]] std::vector<Probe> probes_near(const LabelImage& image, const ImageDomain& domain,
                                             const Vec3& centre_mm, double radius_mm);

}  // namespace lumesh::fitting
