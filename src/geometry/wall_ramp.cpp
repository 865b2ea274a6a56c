#include "lumesh/geometry/wall_ramp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>

namespace lumesh {

Eigen::Matrix<double, 2, WallRamp::kUnknowns> WallRamp::parts_at(const Vec3& off_mm) const {
  const std::complex<double> z(off_mm.dot(u_) / reach_mm_, off_mm.dot(v_) / reach_mm_);
  Eigen::Matrix<double, 2, kUnknowns> parts;
  parts.col(0) << z.real(), z.imag();
  std::complex<double> power = 1;
  for (int k = 0; k < kWaves; ++k, power *= std::conj(z)) {
    parts.col(1 + 2 * k) << power.real(), power.imag();
    parts.col(2 + 2 * k) << -power.imag(), power.real();
  }
  return parts;
}

Vec3 WallRamp::slope(const Vec3& off_mm) const {
  const Eigen::Vector2d across = parts_at(off_mm) * slopes_;
  return across.x() * u_ + across.y() * v_;
}

double WallRamp::strain() const {
  double sum = std::abs(slopes_[0]);
  for (int k = 1; k < kWaves; ++k) sum += k * slopes_.segment<2>(1 + 2 * k).norm();
  return kHighest * length_mm_ / reach_mm_ * sum;
}

void WallRamp::limit(double steepest, double cosine) {
  constexpr double kMaxFold = 0.75;  // At 1 the section might fold on its way.
  const double lean = std::sqrt(std::max(0.0, 1 - cosine * cosine)) / cosine;
  const double times = std::max({1.0, steepest / kSteepest, (strain() + lean * steepest) / kMaxFold});
  slopes_ /= times;
  // A wall that narrows at 20 degrees would leave a neck of 15 % of the area else.
  constexpr double kMaxOff = 0.04;  // Of the reach.
  if (steepest > 0) longest_mm_ = kMaxOff * reach_mm_ * times / (kHighest * steepest);
  set_length(length_mm_);
}

void WallRamp::add_wall(const Vec3& off_mm, const Vec3& normal, double area) {
  const Slopes row = parts_at(off_mm).transpose() * Eigen::Vector2d(normal.dot(u_), normal.dot(v_));
  sums_ += area * row * row.transpose();
  right_ -= area * normal.dot(axis_) * row;
}

void WallRamp::fit() {
  constexpr double kDamping = 1e-3;  // Of the mean of the diagonal: what the walls leave open stays 0.
  if (!(sums_.trace() > 0)) return;
  sums_.diagonal().array() += kDamping / kUnknowns * sums_.trace();
  slopes_ = sums_.ldlt().solve(right_);
}

}  // namespace lumesh
