#pragma once
/// @file Points on triangles, and what is said about values at them.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/hausdorff.hpp"
#include "lumesh/surface/distance.hpp"

namespace lumesh::quality {

/// A value at a place; weight 0 counts for the maximum only.
struct WeightedValue {
  double value = 0;
  double weight = 0;
  Vec3 place_mm = Vec3::Zero();
};

/// The value below which 95 % of the weight lies, to single precision.
[[nodiscard]] inline double percentile_95(const std::vector<WeightedValue>& values, double total_weight) {
  // Floats that are not negative order like their bits: sorting (value, weight) as one word is quick.
  std::vector<std::uint64_t> keys(values.size());
  parallel::for_each_index(values.size(), [&](std::size_t i) {
    const auto value = std::bit_cast<std::uint32_t>(static_cast<float>(values[i].value));
    keys[i] = std::uint64_t{value} << 32 | std::bit_cast<std::uint32_t>(static_cast<float>(values[i].weight));
  });
  parallel::sort(keys.begin(), keys.end());
  double below = 0;
  for (const std::uint64_t key : keys) {
    below += std::bit_cast<float>(static_cast<std::uint32_t>(key));
    if (below >= 0.95 * total_weight) return std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32));
  }
  return 0;
}

/// Maximum, and mean and 95th percentile by weight. Values are >= 0.
[[nodiscard]] inline DistanceSummary summarise(const std::vector<WeightedValue>& values) {
  DistanceSummary summary;
  summary.samples = values.size();
  double weight = 0, sum = 0;
  for (const WeightedValue& v : values) {
    weight += v.weight;
    sum += v.weight * v.value;
    if (v.value < summary.max) continue;
    summary.max = v.value;
    summary.worst_mm = v.place_mm;
  }
  if (!(weight > 0)) return summary;
  summary.mean = sum / weight;
  summary.p95 = std::min(percentile_95(values, weight), summary.max);
  return summary;
}

/// Calls visit(point, weight) at the centres of n^2 equal parts of a triangle (weights add up to its area)
/// and at its corners (weight 0). n is the least number >= 2 with no part's edge above `spacing`.
template <class Visit>
void sample_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double spacing, const Visit& visit) {
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const int n = static_cast<int>(std::clamp(std::ceil(longest / spacing), 2.0, 1000.0));
  const double weight = triangle_area(a, b, c) / (static_cast<double>(n) * n);
  for (const Vec3* corner : {&a, &b, &c}) visit(*corner, 0.0);
  surfaces::for_each_part_centre(a, b, c, n, [&](const Vec3& p) { visit(p, weight); });
}

}  // namespace lumesh::quality
