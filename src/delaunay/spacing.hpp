#pragma once
/// @file The two lengths that guide refinement, at every place.

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
  [[nodiscard]] double size_at(const Vec3& x, Material m) const;
  /// Wanted spacing of points at a place of the boundary between two materials: less where what is meshed, or
  /// a gap, is so thin that points of its two sides would stand for each other.
  [[nodiscard]] double surface_spacing_at(const Vec3& x, Material first, Material second) const;
  /// True if size_at() is the same everywhere.
  [[nodiscard]] bool is_constant() const { return sizing_ == nullptr; }
  [[nodiscard]] const Domain& domain() const { return *domain_; }
  [[nodiscard]] double delta_mm() const { return delta_mm_; }
  [[nodiscard]] double size_mm() const { return size_mm_; }

 private:
  [[nodiscard]] double spacing_of_thin_parts(const Vec3& x, Material first, Material second) const;
  [[nodiscard]] double thickness(const Vec3& x, const Vec3& direction, Material of, double most) const;

  const Domain* domain_;
  double delta_mm_, size_mm_;
  const Sizing* sizing_;
};

}  // namespace lumesh::delaunay
