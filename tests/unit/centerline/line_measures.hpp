#pragma once
/// @file How far lines are from known axes.

#include <algorithm>
#include <cmath>
#include <vector>

#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh::test {

/// A point of an axis with the radius there.
struct AxisSample {
  Vec3 point;
  double radius = 0;
};

/// Points along lines at gaps of at most `step`.
inline std::vector<AxisSample> samples_of(const Polylines& lines, double step) {
  const std::vector<double>& radius = lines.scalars.at("radius");
  std::vector<AxisSample> samples;
  for (const std::vector<std::uint32_t>& line : lines.lines)
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Vec3 &a = lines.points[line[i - 1]], &b = lines.points[line[i]];
      const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
      for (int p = 0; p < parts; ++p) {
        const double t = (p + 0.5) / parts;
        samples.push_back({a + t * (b - a), (1 - t) * radius[line[i - 1]] + t * radius[line[i]]});
      }
    }
  return samples;
}

inline std::vector<AxisSample> samples_of(const std::vector<PhantomCurve>& curves, double step) {
  Polylines lines;
  for (const PhantomCurve& curve : curves) {
    std::vector<std::uint32_t>& line = lines.lines.emplace_back();
    for (std::size_t i = 0; i < curve.points_mm.size(); ++i) {
      line.push_back(static_cast<std::uint32_t>(lines.points.size()));
      lines.points.push_back(curve.points_mm[i]);
      lines.scalars["radius"].push_back(curve.radius_mm[i]);
    }
  }
  return samples_of(lines, step);
}

struct Deviations {
  double mean = 0;
  double largest = 0;
  double radius = 0;  ///< Mean relative difference to the radius of the nearest sample.
};

/// From each of `from` to the nearest of `to`.
inline Deviations deviations(const std::vector<AxisSample>& from, const std::vector<AxisSample>& to) {
  Deviations result;
  for (const AxisSample& sample : from) {
    const auto nearest =
        std::min_element(to.begin(), to.end(), [&](const AxisSample& a, const AxisSample& b) {
          return (a.point - sample.point).squaredNorm() < (b.point - sample.point).squaredNorm();
        });
    const double distance = (nearest->point - sample.point).norm();
    result.mean += distance / static_cast<double>(from.size());
    result.largest = std::max(result.largest, distance);
    result.radius += std::abs(sample.radius / nearest->radius - 1) / static_cast<double>(from.size());
  }
  return result;
}

}  // namespace lumesh::test
