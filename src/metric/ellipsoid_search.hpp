#pragma once
/// @file Khachiyan's search with away steps, with buffers that many searches share.

#include <array>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"

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
/// Cost: about 6 us for 40 points, linear in their number.
/// Sources: Khachiyan 1996, doi:10.1287/moor.21.2.307, with the away steps and the end of Todd and Yildirim
/// 2007, doi:10.1016/j.dam.2007.02.013, and the first points of Kumar and Yildirim 2005,
/// doi:10.1007/s10957-005-2653-6; written out in docs/stages/metric.md, "Points".
class EllipsoidSearch {
 public:
  /// @param options  In their ranges.
  explicit EllipsoidSearch(const EllipsoidOptions& options) : options_(options) {}

  /// Finds one after the other; each depends on its points alone, of which there is one at least, all finite.
  [[nodiscard]] Ellipsoid around(std::span<const Vec3> points);

 private:
  template <int D>
  struct Shape;  // Of an ellipsoid across D axes.
  template <int D>
  class Ascent;

  void turn_to_principal_axes(std::span<const Vec3> points);
  template <int D>
  void fill_across(const std::array<int, 3>& kept, Ellipsoid& ellipsoid);

  EllipsoidOptions options_;
  Vec3 mean_ = Vec3::Zero();
  Mat3 axes_ = Mat3::Identity();
  std::size_t count_ = 0;
  std::array<std::vector<double>, 3> along_;  // Coordinates of the points in the principal axes.
  Vec3 middle_ = Vec3::Zero(), half_range_ = Vec3::Zero();  // Of these.
  std::vector<double> weights_, distances_, products_;
};

}  // namespace lumesh::metric
