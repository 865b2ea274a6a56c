#include "lumesh/metric/analytic.hpp"

#include <algorithm>
#include <cmath>

namespace lumesh::metric {
namespace {

constexpr double kSmallest = 0.001, kLargest = 0.1, kTangentialAtLayer = 0.025;

/// The smallest size at the layer, growing linearly to both sides of it.
double size_across_layer(double distance) {
  return kSmallest + 2 * (kLargest - kSmallest) * std::abs(distance);
}

SymTensor with_axes(const Vec3& radial, const Vec3& tangential, double along_radial, double along_tangential,
                    double along_z) {
  const double a = along_radial, b = along_tangential;
  return {a * radial[0] * radial[0] + b * tangential[0] * tangential[0],
          a * radial[0] * radial[1] + b * tangential[0] * tangential[1],
          0,
          a * radial[1] * radial[1] + b * tangential[1] * tangential[1],
          0,
          along_z};
}

MetricPair from_polar_sizes(const Vec3& point, double r, double size_r, double size_t, double size_z) {
  const Vec3 radial = r > 0 ? Vec3(point[0] / r, point[1] / r, 0) : Vec3(1, 0, 0);
  const Vec3 tangential(-radial[1], radial[0], 0);
  const auto value = [](double size) { return 1 / (size * size); };
  const auto log_value = [](double size) { return -2 * std::log(size); };
  return {with_axes(radial, tangential, value(size_r), value(size_t), value(size_z)),
          with_axes(radial, tangential, log_value(size_r), log_value(size_t), log_value(size_z))};
}

}  // namespace

MetricPair analytic_metric(AnalyticKind kind, const Vec3& point, double size_factor) {
  const double f = size_factor;
  if (kind == AnalyticKind::kLinear)
    return from_polar_sizes(Vec3::Zero(), 0, f * kLargest, f * kLargest,
                            f * size_across_layer(point[2] - 0.5));
  const double r = std::hypot(point[0], point[1]);
  const double d = std::min(1.0, 10 * std::abs(r - 0.5));
  const double tangential =
      kind == AnalyticKind::kPolar1 ? kLargest : kLargest * d + kTangentialAtLayer * (1 - d);
  return from_polar_sizes(point, r, f * size_across_layer(r - 0.5), f * tangential, f * kLargest);
}

}  // namespace lumesh::metric
