#pragma once
/// @file The two lengths that guide refinement, at every place.

#include <algorithm>
#include <limits>

#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/domain/domain.hpp"

namespace lumesh::delaunay {

/// Edges on a surface whose points are at least d apart, and at most d from any of its places, have this mean
/// length in units of d.
inline constexpr double kEdgePerSpacing = 1.3;
/// Circumradius of a regular tetrahedron whose edges are sqrt(2) long: where larger, edges are too long.
inline constexpr double kRadiusPerSize = 0.866;

class Spacing {
 public:
  /// @param delta_mm  Spacing of the points of surfaces. @param sizing  May be null.
  Spacing(const Domain& domain, double delta_mm, double size_mm, const Sizing* sizing)
      : domain_(&domain), delta_mm_(delta_mm), size_mm_(size_mm), sizing_(sizing) {}

  /// Wanted edge length inside a material.
  [[nodiscard]] double size_at(const Vec3& x, Material m) const {
    return sizing_ == nullptr ? size_mm_ : std::min(size_mm_, sizing_->size_at(x, domain_->label_of(m)));
  }
  /// Wanted spacing of points on the boundary between two materials.
  [[nodiscard]] double surface_spacing_at(const Vec3& x, Material first, Material second) const {
    if (sizing_ == nullptr) return delta_mm_;
    double size = std::numeric_limits<double>::infinity();
    for (const Material m : {first, second})
      if (domain_->is_meshed(m)) size = std::min(size, sizing_->size_at(x, domain_->label_of(m)));
    return std::min(delta_mm_, size / kEdgePerSpacing);
  }
  [[nodiscard]] bool is_constant() const { return sizing_ == nullptr; }
  [[nodiscard]] const Domain& domain() const { return *domain_; }
  [[nodiscard]] double delta_mm() const { return delta_mm_; }
  [[nodiscard]] double size_mm() const { return size_mm_; }

 private:
  const Domain* domain_;
  double delta_mm_, size_mm_;
  const Sizing* sizing_;
};

}  // namespace lumesh::delaunay
