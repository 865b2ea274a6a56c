#pragma once
/// @file Options of the sources that a metric is made of.

#include <limits>
#include <span>

#include "lumesh/core/types.hpp"

namespace lumesh {
class OptionList;
}

namespace lumesh::metric {

/// How points, such as those of centerlines, make a metric: metric_from_points().
struct PointMetricOptions {
  int k = 40;               ///< Nearest points that an ellipsoid encloses, >= 1.
  double tolerance = 0.01;  ///< EllipsoidOptions::tolerance, of its volume; in (0, 1].
  double floor_mm = 0;      ///< The least size; 0: the median distance from a point to its nearest one.
  bool isotropic = false;   ///< Instead of ellipsoids, sizes the same in all directions: the mean distance
                            ///< from the place to these points.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How the gradient of a velocity makes a metric: metric_from_velocity().
struct VelocityMetricOptions {
  int k = 20;  ///< Nearest samples that a gradient is fitted to, >= 3. Fewer than 15 do not determine
               ///< it: what they leave open is taken to be 0.
  double change = 0.2;  ///< Share of the speed by which the velocity changes across an edge where it changes
                        ///< most, > 0.
  double stretch = 12;  ///< Largest size to smallest, >= 1.
  double flatness = 1.4;  ///< Larger size across the flow to the smaller one, where the velocity changes
                          ///< along one of them only, >= 1.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How second derivatives of a solution make a metric: metric_from_hessian().
struct HessianMetricOptions {
  double norm =
      2;  ///< p of the Lp norm, >= 1, may be infinite: small numbers see weak features, large ones shocks.

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.
};

/// How the curvature of walls makes a metric: metric_from_curvature().
struct CurvatureOptions {
  double chord_mm = 0;          ///< How far a chord may stand off the arc, >= 0; 0: edges per radius decide.
  double edges_per_radius = 2;  ///< Edges as long as the radius of curvature's share, > 0.
  double largest_mm = std::numeric_limits<double>::infinity();  ///< Size where nothing bends, > 0; infinite:
                                                                ///< the mesh's diagonal.
  double feature_angle_deg = 50;  ///< Faces that turn by more do not belong to one smooth surface; (0, 180].

  /// Options that users may choose, which need the source.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the option.

  /// The wanted size along an arc of this curvature (>= 0): 2 sqrt(chord (2 R - chord)) of the radius R, the
  /// chord whose middle stands off by chord_mm, and 2 R at most; or R / edges_per_radius; at most `largest`.
  [[nodiscard]] double size_of(double curvature, double largest) const;
  /// largest_mm, or the diagonal of the box around these points.
  [[nodiscard]] double largest_of(std::span<const Vec3> points) const;
};

}  // namespace lumesh::metric
