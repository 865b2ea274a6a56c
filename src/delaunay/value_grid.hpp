#pragma once
/// @file Values at the points of a grid, and between them.

#include <algorithm>
#include <array>
#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"

namespace lumesh::delaunay {

/// The eight grid points around a place and their weights in trilinear interpolation. Places outside count as
/// on the border.
class WeightedCorners {
 public:
  /// @param index  Finite. @param size  Grid points along the axes, each >= 1; x runs fastest.
  WeightedCorners(const Vec3& index, const Index3& size) {
    std::size_t stride = 1;
    for (int a = 0; a < 3; ++a) {
      const double inside = std::clamp(index[a], 0.0, static_cast<double>(size[a] - 1));
      const int low = std::clamp(static_cast<int>(inside), 0, std::max(size[a] - 2, 0));
      first_ += static_cast<std::size_t>(low) * stride;
      steps_[a] = size[a] > 1 ? stride : 0;
      shares_[a] = {1 - (inside - low), inside - low};
      stride *= static_cast<std::size_t>(size[a]);
    }
  }
  [[nodiscard]] std::size_t offset(int corner) const {
    return first_ + (corner & 1) * steps_[0] + (corner >> 1 & 1) * steps_[1] + (corner >> 2) * steps_[2];
  }
  [[nodiscard]] double weight(int corner) const {
    return shares_[0][corner & 1] * shares_[1][corner >> 1 & 1] * shares_[2][corner >> 2];
  }

 private:
  std::size_t first_ = 0;
  std::array<std::size_t, 3> steps_ = {};
  std::array<std::array<double, 2>, 3> shares_ = {};
};

/// A grid along the axes. Const members may run at the same time.
class ValueGrid {
 public:
  ValueGrid(const Vec3& origin_mm, double spacing_mm, const Index3& size)
      : origin_mm_(origin_mm), spacing_mm_(spacing_mm), size_(size), values_(grid_count(size)) {}

  [[nodiscard]] double at(const Vec3& point_mm) const {
    const WeightedCorners corners((point_mm - origin_mm_) / spacing_mm_, size_);
    double sum = 0;
    for (int c = 0; c < 8; ++c) sum += corners.weight(c) * values_[corners.offset(c)];
    return sum;
  }
  [[nodiscard]] double spacing_mm() const { return spacing_mm_; }
  [[nodiscard]] const Index3& size() const { return size_; }
  [[nodiscard]] Vec3 point(const Index3& at) const { return origin_mm_ + spacing_mm_ * at.cast<double>(); }
  [[nodiscard]] std::vector<float>& values() { return values_; }
  [[nodiscard]] std::size_t offset(const Index3& at) const { return grid_offset(size_, at); }

 private:
  Vec3 origin_mm_;
  double spacing_mm_;
  Index3 size_;
  std::vector<float> values_;
};

/// Distances in mm to the nearest boundary between materials, around all that is meshed, on a grid of the
/// domain's resolution, or of two million points, a quarter of a million for surfaces, if that is coarser.
/// Parallel inside; bitwise identical for every thread count.
[[nodiscard]] ValueGrid boundary_distances(const Domain& domain);

}  // namespace lumesh::delaunay
