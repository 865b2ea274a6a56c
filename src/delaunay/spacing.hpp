#pragma once
/// @file The two lengths that guide refinement, at every place.

#include <algorithm>
#include <array>

#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/parallel/concurrent_map.hpp"

namespace lumesh::delaunay {

/// Edges on a surface whose points are at least d apart, and at most d from any of its places, have this mean
/// length in units of d.
inline constexpr double kEdgePerSpacing = 1.3;
/// Size inside, in units of the edges on surfaces, above which sizes grow from these: the lattice reaches the
/// boundary with larger cells no more.
inline constexpr double kMuchLarger = 1.2;
/// Growth of these sizes per distance from surfaces.
inline constexpr double kGrowthInwards = 0.6;
/// Spacing along the rim of a small opening in units of its radius: eight or nine edges go around.
inline constexpr double kSpacingPerEndRadius = 0.54;
/// Circumradius of a regular tetrahedron whose edges are sqrt(2) long: where larger, edges are too long.
inline constexpr double kRadiusPerSize = 0.866;

class Spacing {
 public:
  /// @param delta_mm  Spacing of the points of surfaces. @param surface_distance_mm  How far flat triangles
  /// may stand off where surfaces bend; infinite: no limit. @param sizing  May be null.
  Spacing(const Domain& domain, double delta_mm, double size_mm, double surface_distance_mm,
          const Sizing* sizing)
      : domain_(&domain),
        delta_mm_(delta_mm),
        size_mm_(size_mm),
        surface_distance_mm_(surface_distance_mm),
        cube_mm_(std::max(domain.resolution_mm(), delta_mm)),
        sizing_(sizing) {}

  /// Wanted edge length inside a material.
  [[nodiscard]] double size_at(const Vec3& x, Material m) const;
  /// See Sizing::wants_finer().
  [[nodiscard]] bool wants_finer(const std::array<Vec3, 4>& corners) const {
    return sizing_ != nullptr && sizing_->wants_finer(corners);
  }
  /// Wanted spacing of points at a place of the boundary between two materials: less where what is meshed, or
  /// a gap, is so thin that points of its two sides would stand for each other, or where the surface bends.
  [[nodiscard]] double surface_spacing_at(const Vec3& x, Material first, Material second) const;
  /// True at a place of the boundary before which what is meshed is so thin that points have to stand closer
  /// than delta, whether a wall or an opening is behind it.
  [[nodiscard]] bool is_thin_at(const Vec3& x, Material first, Material second) const;
  /// Wanted spacing of points of a curve where materials meet, beside surfaces that want `spacing`: less at
  /// the rims of small openings, which at least eight edges go around.
  [[nodiscard]] double curve_spacing_at(const Vec3& x, const MaterialSet& set, double spacing) const;
  /// Lowest spacing that surface_spacing_at() gives for the sake of shapes.
  [[nodiscard]] double min_for_shapes() const;
  /// True if size_at() is the same everywhere.
  [[nodiscard]] bool is_constant() const { return sizing_ == nullptr; }
  [[nodiscard]] const Domain& domain() const { return *domain_; }
  [[nodiscard]] double delta_mm() const { return delta_mm_; }
  [[nodiscard]] double size_mm() const { return size_mm_; }

 private:
  /// A cube of space, about as large as delta, and two materials.
  struct Place {
    std::array<std::int32_t, 3> cube;
    std::array<Material, 2> pair;
    friend bool operator==(const Place&, const Place&) = default;
  };
  struct HashOfPlace {
    std::size_t operator()(const Place& place) const;
  };

  /// Spacing for thin parts and bends: for the shape, not for sizes that are asked for.
  [[nodiscard]] double spacing_of_shape(const Vec3& x, Material first, Material second) const;
  [[nodiscard]] double measured_spacing(const Place& place) const;
  [[nodiscard]] double spacing_of_thin_parts(const Vec3& x, const Vec3& towards_first,
                                             const Place& place) const;
  [[nodiscard]] double spacing_of_bends(const Vec3& x, const Vec3& gradient, const Place& place) const;
  [[nodiscard]] double thickness(const Vec3& x, const Vec3& direction, Material of, double max_mm,
                                 bool cuts_count = false) const;

  const Domain* domain_;
  double delta_mm_, size_mm_, surface_distance_mm_, cube_mm_;
  const Sizing* sizing_;
  /// Spacings measured so far; the same whichever thread asks first.
  mutable parallel::ConcurrentMap<Place, float, HashOfPlace> measured_;
};

}  // namespace lumesh::delaunay
