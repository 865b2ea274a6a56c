#include "lumesh/metric/velocity_metric.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/metric/point_tree.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

namespace {

struct DistinctSamples {
  std::vector<Vec3> points, velocities;
};

/// In an order that does not depend on that of the samples; those at one place as their mean.
DistinctSamples distinct_samples(const VelocitySamples& samples) {
  const std::span<const Vec3> points = samples.points, velocities = samples.velocities;
  LUMESH_ASSERT(points.size() == velocities.size());
  constexpr double kLargest = 1e100;  // Squares of speeds are summed.
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite() || !velocities[i].allFinite() ||
        velocities[i].cwiseAbs().maxCoeff() > kLargest)
      throw Error(
          ErrorKind::kBadInput,
          fmt::format(
              "the {} of point {}, counted from 0, is {}", points[i].allFinite() ? "velocity" : "place", i,
              points[i].allFinite() && velocities[i].allFinite() ? "larger than 1e100" : "not finite"));
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  parallel::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const auto key = [&](std::uint32_t s) {
      return std::make_tuple(points[s][0], points[s][1], points[s][2], velocities[s][0], velocities[s][1],
                             velocities[s][2], s);
    };
    return key(i) < key(j);
  });
  DistinctSamples distinct;
  const auto same = [&](std::uint32_t i, std::uint32_t j) { return points[i] == points[j]; };
  parallel::for_each_run(order, same, [&](std::span<const std::uint32_t> run) {
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t s : run) sum += velocities[s];
    distinct.points.emplace_back(points[run[0]] + Vec3::Zero());  // -0 becomes 0.
    distinct.velocities.emplace_back(sum / static_cast<double>(run.size()));
  });
  return distinct;
}

VelocityFit fit_at(const Vec3& place, const DistinctSamples& samples,
                   std::span<const std::uint32_t> nearest) {
  constexpr double kTikhonov = 1e-6;
  const double reach = (samples.points[nearest.back()] - place).squaredNorm();
  double sum = 0;
  Vec3 middle = Vec3::Zero(), velocity = Vec3::Zero();
  const auto weight = [&](std::uint32_t i) {
    return std::exp(-2 * (samples.points[i] - place).squaredNorm() / reach);
  };
  for (const std::uint32_t i : nearest) {
    const double w = weight(i);
    sum += w;
    middle += w * (samples.points[i] - place);
    velocity += w * samples.velocities[i];
  }
  middle /= sum;
  velocity /= sum;
  Mat3 squares = Mat3::Zero(), products = Mat3::Zero();
  for (const std::uint32_t i : nearest) {
    const Vec3 offset = samples.points[i] - place - middle;
    const Vec3 weighted = weight(i) * offset;
    squares += weighted * offset.transpose();
    products += (samples.velocities[i] - velocity) * weighted.transpose();
  }
  squares.diagonal().array() += kTikhonov * squares.trace();
  return {velocity, squares.ldlt().solve(products.transpose()).transpose()};
}

std::vector<VelocityFit> fit(std::span<const Vec3> places, const DistinctSamples& samples, int k) {
  require_as_many(samples.points.size(), static_cast<std::size_t>(k));
  if (places.empty()) return {};
  require_near_points(places, samples.points);
  const PointTree tree(samples.points);
  std::vector<VelocityFit> fits(places.size());
  for_each_along_curve(places, [&] {
    return [&, nearest = std::vector<std::uint32_t>(static_cast<std::size_t>(k))](std::uint32_t i) mutable {
      tree.nearest(places[i], nearest);
      fits[i] = fit_at(places[i], samples, nearest);
    };
  });
  return fits;
}

/// How fast the velocity changes along directions: P = (G^T G)^(1/2), the symmetric factor of the polar
/// decomposition of G, whose eigenvalues are |G d| (docs/stages/metric.md, "Velocity").
struct Rates {
  Mat3 tensor = Mat3::Zero();
  double largest = 0;
};

Rates rates_of(const Mat3& gradient) {
  const double norm = gradient.norm();
  if (!(norm > 0)) return {};
  const Mat3 unit = gradient / norm;  // Squares of it neither over- nor underflow.
  const EigenSystem squares = eigen_system(SymTensor::from(unit.transpose() * unit));
  const Vec3 values = norm * squares.values.cwiseMax(0.0).cwiseSqrt();
  return {squares.axes * values.asDiagonal() * squares.axes.transpose(), values.maxCoeff()};
}

/// Scales that the sizes of all places are measured by.
struct FlowScale {
  double gradient = 0;  // G_0; 0 where nothing flows.
  double size = 0;      // h_0.
};

FlowScale scale_of(const std::vector<Rates>& rates, const DistinctSamples& samples, double diagonal,
                   double change) {
  constexpr double kConstant = 1e-3;
  double squares = 0;
  for (const Vec3& u : samples.velocities) squares += u.squaredNorm();
  const double speed = std::sqrt(squares / static_cast<double>(samples.velocities.size()));
  if (!(speed > 0)) return {0, diagonal};
  std::vector<double> largest(rates.size());
  std::transform(rates.begin(), rates.end(), largest.begin(), [](const Rates& r) { return r.largest; });
  const std::size_t rank = largest.size() * 95 / 100;
  const double gradient = std::max(value_of_rank(std::move(largest), rank), kConstant * speed / diagonal);
  return {gradient, std::min(change * speed / gradient, diagonal)};
}

/// M = ((1 - 1/s^2) g S + I/s^2) / h_0^2, S = (1 - 1/f^2) P/sigma + (I - t t^T)/f^2, g = min(sigma/G_0, 1):
/// derived in docs/stages/metric.md, "Velocity".
SymTensor tensor_of(const Vec3& velocity, const Rates& rates, const FlowScale& scale,
                    const VelocityMetricOptions& options) {
  const double least = 1 / (options.stretch * options.stretch);
  Mat3 shape = least * Mat3::Identity();
  if (scale.gradient > 0 && rates.largest > 0) {
    const double round = 1 / (options.flatness * options.flatness);
    Mat3 across = Mat3::Identity();
    if (const double speed = velocity.norm(); speed > 0)
      across -= (velocity / speed) * (velocity / speed).transpose();
    const Mat3 unit = (1 - round) / rates.largest * rates.tensor + round * across;
    shape += (1 - least) * std::min(rates.largest / scale.gradient, 1.0) * unit;
  }
  return SymTensor::from(shape / (scale.size * scale.size));
}

}  // namespace

void VelocityMetricOptions::describe(OptionList& list) {
  list.number("velocity_k", k, between(3, 10000), "Samples nearest to a vertex that count; 3 is the paper's")
      .needs("velocity");
  list.number("velocity_change", change, {.min = 0, .max = 10, .excludes_min = true},
              "Change of the velocity across an edge where it changes most, over the samples' mean speed")
      .needs("velocity");
  list.number("velocity_stretch", stretch, between(1, 1000), "Largest size over the smallest")
      .needs("velocity");
  list.number("velocity_flatness", flatness, between(1, 1000),
              "Larger size across the flow over the smaller one, where the velocity changes along one of "
              "them only")
      .needs("velocity");
}

void VelocityMetricOptions::validate() const {
  require_ranges_of(*this);
}

std::vector<VelocityFit> fit_velocities(std::span<const Vec3> places, const VelocitySamples& samples, int k) {
  VelocityMetricOptions{.k = k}.validate();
  return fit(places, distinct_samples(samples), k);
}

std::vector<SymTensor> metric_from_velocity(std::span<const Vec3> places, const VelocitySamples& samples,
                                            const VelocityMetricOptions& options) {
  options.validate();
  const DistinctSamples distinct = distinct_samples(samples);
  const std::vector<VelocityFit> fits = fit(places, distinct, options.k);
  if (fits.empty()) return {};
  std::vector<Rates> rates(fits.size());
  parallel::for_each_index(fits.size(), [&](std::size_t i) { rates[i] = rates_of(fits[i].gradient); });
  const FlowScale scale = scale_of(rates, distinct, bounding_box(places).sizes().norm(), options.change);
  std::vector<SymTensor> metric(places.size());
  parallel::for_each_index(metric.size(), [&](std::size_t i) {
    metric[i] = tensor_of(fits[i].velocity, rates[i], scale, options);
  });
  return metric;
}

}  // namespace lumesh::metric
