#pragma once
// What a fit is given: the image, its domain, limits of the dihedral angles, places that vertices shall
// reach.

#include <algorithm>
#include <optional>
#include <vector>

#include "lumesh/core/angles.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::fitting {

struct AngleLimits {
  double min_deg;
  double max_deg;
};

/// The angle quality of a tetrahedron is min(4 (1 - cos smallest), 1 + cos largest) of its dihedral angles:
/// 4/3 for the regular one, 0 for a flat one. It weighs 10 deg like 160, 15 like 150, 20 like 140 and 30 like
/// 120 deg. This is the lowest quality that keeps both limits. Derived in docs/stages/lattice.md, "Formulas".
inline double angle_floor(const AngleLimits& limits) {
  return std::max(4 * (1 - cosine_deg(limits.min_deg)), 1 + cosine_deg(limits.max_deg));
}

/// Input of a fit; all of it must outlive the fit.
struct FitSetting {
  const LabelImage& image;
  const ImageDomain& domain;
  AngleLimits limits;
};

/// Places of vertices other than on the nearest boundary.
struct VertexTargets {
  std::vector<double> offset_mm;                ///< Distance from the boundary.
  std::vector<std::optional<Vec3>> anchors_mm;  ///< Places that the surface passes by, anchors.hpp.

  void resize(std::size_t vertices) {
    offset_mm.resize(vertices, 0.0);
    anchors_mm.resize(vertices);
  }
};

}  // namespace lumesh::fitting
