#pragma once
/// @file Khachiyan's search with away steps, with buffers that many searches share.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/metric/ellipsoid.hpp"

namespace lumesh::metric {

/// Finds one ellipsoid after the other; each depends on its points alone.
class EllipsoidSearch {
 public:
  /// @param options  In their ranges.
  explicit EllipsoidSearch(const EllipsoidOptions& options) : options_(options) {}

  /// As minimum_volume_ellipsoid().
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
