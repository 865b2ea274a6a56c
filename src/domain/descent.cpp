#include "descent.hpp"

#include <Eigen/Dense>

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
  // Gauss-Newton with the least step: the separations of all pairs vanish together. Two labels that share a
  // wall against a third have nearly the same separation from it, so that no one material will do to count
  // from.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vec3 downhill = Vec3::Zero();
  for (std::size_t i = 0; i < set.size(); ++i) {
    for (std::size_t j = i + 1; j < set.size(); ++j) {
      const FieldSample s = domain.separation(x, set[i], set[j]);
      if (s.gradient.squaredNorm() < kFlat) continue;
      normal += s.gradient * s.gradient.transpose();
      downhill -= s.value * s.gradient;
    }
  }
  if (!(normal.trace() > kFlat)) return Vec3::Constant(NAN);
  normal.diagonal().array() += 1e-6 * normal.trace();
  return normal.inverse() * downhill;
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
