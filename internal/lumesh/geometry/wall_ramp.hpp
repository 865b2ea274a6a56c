#pragma once
/// @file How a wall that tapers or leans goes over to a straight extension. Derived in docs/stages/layers.md,
/// "From the wall to the extension".

#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Ways across the axis of an extension that places of its section go: t (1 - t / L)^2 w at the length t
/// along it, where w is the slope of the wall, and 0 from L on.
class WallRamp {
 public:
  /// A level ramp, until slopes are fitted. @param reach_mm  Of the section, from its centre.
  WallRamp(const Vec3& axis, double reach_mm)
      : axis_(axis), u_(axis.unitOrthogonal()), v_(axis.cross(u_)), reach_mm_(reach_mm) {}

  static constexpr double kRadii = 1.5;  ///< Its length, of the section, where the extension has that.
  static constexpr double kSteepest =
      0.36;  ///< Tangent of 20 degrees: steeper walls keep the rest of a crease.
  /// The greatest displacement, that at L / 3, over length and slope.
  static constexpr double kHighest = 4.0 / 27;
  /// Bound of all displacements once limit() was called.
  [[nodiscard]] double max_displacement_mm() const { return kHighest * kSteepest * length_mm_; }
  [[nodiscard]] double length_mm() const { return length_mm_; }
  /// Not more than limit() allows.
  void set_length(double length_mm) { length_mm_ = std::min(length_mm, longest_mm_); }
  /// The slope across the axis, by length along it. @param off_mm  From the section's centre, as everywhere
  /// here.
  [[nodiscard]] Vec3 slope(const Vec3& off_mm) const;
  [[nodiscard]] Vec3 displacement(const Vec3& off_mm, double along_mm) const {
    if (along_mm <= 0 || along_mm >= length_mm_) return Vec3::Zero();
    const double left = 1 - along_mm / length_mm_;
    return along_mm * left * left * slope(off_mm);
  }
  /// Division of all slopes by as much as makes none steeper than kSteepest and folds nothing, by the length
  /// that was set, and a bound of the length, for displacements of 4 % of the reach at most. @param steepest
  /// Of the slopes at the section's places. @param cosine  Of the axis and the section's normal.
  void limit(double steepest, double cosine);

  /// A face of the wall, with its unit normal, that fit() has slopes follow.
  void add_wall(const Vec3& off_mm, const Vec3& normal, double area);
  void fit();

 private:
  static constexpr int kWaves = 4;  // Around the axis, from 0: lean, ellipse, and so on.
  static constexpr int kUnknowns = 1 + 2 * kWaves;
  using Slopes = Eigen::Matrix<double, kUnknowns, 1>;

  /// The greatest change of a distance across the axis, as a part of it.
  [[nodiscard]] double strain() const;
  /// Slopes, along u and v, that each of the unknowns gives a place.
  [[nodiscard]] Eigen::Matrix<double, 2, kUnknowns> parts_at(const Vec3& off_mm) const;

  Vec3 axis_, u_, v_;
  double reach_mm_, length_mm_ = 0;
  double longest_mm_ = std::numeric_limits<double>::infinity();
  Slopes slopes_ = Slopes::Zero();
  Eigen::Matrix<double, kUnknowns, kUnknowns> sums_ = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Slopes right_ = Slopes::Zero();
};

}  // namespace lumesh
