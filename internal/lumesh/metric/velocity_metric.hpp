#pragma once
/// @file A metric from the gradient of a flow's velocity.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/metric/sources.hpp"

namespace lumesh::metric {

/// Velocities at points, one each, in any unit.
struct VelocitySamples {
  std::span<const Vec3> points;
  std::span<const Vec3> velocities;
};

/// The velocity about a place, and how it changes.
struct VelocityFit {
  Vec3 velocity = Vec3::Zero();  ///< Mean of the samples nearby.
  Mat3 gradient = Mat3::Zero();  ///< Row i is the gradient of component i, per unit of the coordinates.
};

/// Fits linear fields to the k samples nearest to each place by least squares with the weights
/// exp(-2 d^2 / r^2), d a sample's distance and r that of the farthest. Directions in which the samples
/// hardly extend get no gradient (Tikhonov's term, 10^-6 of the sum of squares), so that three samples give
/// the solution of least norm. Samples at one place count as one with their mean.
/// @throws as metric_from_velocity(). Parallel inside, bitwise identical for every thread count.
[[nodiscard]] std::vector<VelocityFit> fit_velocities(std::span<const Vec3> places,
                                                      const VelocitySamples& samples, int k);

/// For every place, with the velocity u, its direction t = u / |u| and its gradient G,
///
///   M = 1 / h_0^2 ((1 - 1 / s^2) |G| / G_0 S + I / s^2),   P = (G^T G)^(1/2),
///   S = (1 - 1 / f^2) P / |G| + (I - t t^T) / f^2.
///
/// The eigenvectors of P are the directions along which the velocity changes, its eigenvalues |G d| how fast,
/// the largest of them |G|; G_0 is the 95th percentile of |G| over the places, and |G| / G_0 is at most 1, so
/// that neither the unit of the velocity nor a few large gradients matter. f is `flatness`, s `stretch`, and
/// h_0 = change U / G_0 with the root mean square U of the speed of the samples. All sizes lie between h_0
/// and s h_0; in shear across t with |G| = G_0 they are h_0 along the gradient, about f h_0 across both, and
/// s h_0 along the flow. A flow whose velocity changes by less than U / 1000 over all of the places' box is
/// taken as constant: G_0 is no less than that, and h_0 no more than the box's diagonal. Of a constant flow
/// and where there is none the tensors are the same in all directions.
///
/// @return One tensor per place, per square of the coordinates' unit.
/// @throws Error{kBadInput} if a velocity or a place is not finite, or a speed beyond 10^100 (it names the
/// sample), there are fewer different samples than k, or none lies within one diagonal of the places' box of
/// that; the message does not name a file. Error{kUsage} for options out of range. Parallel inside, bitwise
/// identical for every thread count. Source of the fit: moving least squares, Lancaster and Salkauskas 1981,
/// doi:10.1090/S0025-5718-1981-0616367-1; the metric is derived in docs/stages/metric.md, "Velocity".
[[nodiscard]] std::vector<SymTensor> metric_from_velocity(std::span<const Vec3> places,
                                                          const VelocitySamples& samples,
                                                          const VelocityMetricOptions& options = {});

}  // namespace lumesh::metric
