#pragma once
/// @file The smallest ellipsoid around points.

#include <span>

#include "lumesh/geometry/sym_tensor.hpp"

namespace lumesh::metric {

struct Ellipsoid {
  Vec3 centre = Vec3::Zero();
  Mat3 axes = Mat3::Identity();   ///< Orthonormal columns, along the semi-axes.
  Vec3 semi_axes = Vec3::Zero();  ///< In mm, ascending.

  /// The metric whose unit ball it is: an edge along a semi-axis and as long has length 1. Semi-axes > 0.
  [[nodiscard]] SymTensor metric() const;
};

struct EllipsoidOptions {
  /// How far from the smallest: the search ends where no point stands out of the ellipsoid by more, as a
  /// share of d + 1, d the number of axes searched (epsilon of Todd and Yildirim). The volume is then at most
  /// (1 + tolerance)^((d + 1) / 2) times the smallest. In (0, 1].
  double tolerance = 0.01;
  double floor_mm =
      0;  ///< The least semi-axis, >= 0; a semi-axis 10^7 times shorter than the longest becomes it.
};

/// The ellipsoid of least volume that encloses all points, but for those flatter than the floor: principal
/// axes along which the points reach no further than the floor to either side get that as semi-axis, and the
/// ellipsoid is sought across the others, in a plane or on a line (where it is half the range), so that
/// points in a plane, on a line or in one place are no special case. Points are enclosed up to the floor.
///
/// @param points  At least one, all finite, any order.
/// @throws Error{kUsage} that names an option out of its range; Error{kBadInput} if there is no point.
/// Threads: const on its input. Cost: about 6 us for 40 points, linear in their number.
/// Sources: Khachiyan 1996, doi:10.1287/moor.21.2.307, with the away steps and the end of Todd and Yildirim
/// 2007, doi:10.1016/j.dam.2007.02.013, and the first points of Kumar and Yildirim 2005,
/// doi:10.1007/s10957-005-2653-6; written out in docs/stages/metric.md, "Points".
[[nodiscard]] Ellipsoid minimum_volume_ellipsoid(std::span<const Vec3> points,
                                                 const EllipsoidOptions& options = {});

}  // namespace lumesh::metric
