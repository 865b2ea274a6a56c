#include "descent.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace lumesh {

namespace {

constexpr int kMaxNewtonSteps = 12;

Vec3 newton_step(const Domain& domain, const Vec3& x, const MaterialSet& set) {
  constexpr double kFlat = 1e-3;  // squared slope below which a separation says nothing about its zero
  if (set.size() == 2) {
    const FieldSample s = domain.separation(x, set[0], set[1]);
    const double slope2 = s.gradient.squaredNorm();
    if (slope2 < kFlat) return Vec3::Constant(NAN);
    return s.gradient * (-s.value / slope2);
  }
  // Gauss-Newton with the least step: all separations from the first material vanish together.
  constexpr int kRows = 3;
  Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
  Vec3 residual = Vec3::Zero();
  // Materials come ascending, cut planes last: count from the last, so that a plane meets each label by
  // itself.
  const Material pivot = domain.is_cut(set[set.size() - 1]) ? set[0] : set[set.size() - 1];
  int row = 0;
  for (const Material m : set) {
    if (m == pivot || row == kRows) continue;
    const FieldSample s = domain.separation(x, m, pivot);
    if (s.gradient.squaredNorm() < kFlat) return Vec3::Constant(NAN);
    slope.row(row) = s.gradient.transpose();
    residual[row] = s.value;
    ++row;
  }
  Eigen::Matrix3d normal = slope * slope.transpose();
  normal.diagonal().array() += 1e-6 * normal.trace();
  for (; row < kRows; ++row) normal(row, row) = 1;  // Rows that are not there.
  return -slope.transpose() * (normal.inverse() * residual);
}

}  // namespace

std::optional<Vec3> descend(const Domain& domain, const Vec3& start_mm, const MaterialSet& set,
                            const DescentLimits& limits) {
  Vec3 x = start_mm;
  // The last step is taken; convergence is quadratic, so it leaves much less than its length.
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    const Vec3 move = newton_step(domain, x, set);
    if (!move.allFinite()) return std::nullopt;
    const double length = move.norm();
    x += length > limits.longest_step_mm ? Vec3(move * (limits.longest_step_mm / length)) : move;
    if ((x - start_mm).norm() > limits.reach_mm) return std::nullopt;
    if (length < limits.close_mm) return x;
  }
  return std::nullopt;
}

}  // namespace lumesh
