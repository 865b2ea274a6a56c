#pragma once
/// @file Points on triangles, and what is said about values at them.

#include <algorithm>
#include <cmath>
#include <vector>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/hausdorff.hpp"

namespace lumesh::quality {

/// A value at a place; weight 0 counts for the maximum only.
struct WeightedValue {
  double value = 0;
  double weight = 0;
  Vec3 place_mm = Vec3::Zero();
};

/// Maximum, and mean and 95th percentile by weight. Reorders `values`. The same for every order of equal
/// values.
[[nodiscard]] inline DistanceSummary summarise(std::vector<WeightedValue>& values) {
  DistanceSummary summary;
  summary.samples = values.size();
  if (values.empty()) return summary;
  double weight = 0, sum = 0;
  for (const WeightedValue& v : values) {
    weight += v.weight;
    sum += v.weight * v.value;
  }
  parallel::sort(values.begin(), values.end(), [](const WeightedValue& a, const WeightedValue& b) {
    if (a.value != b.value) return a.value < b.value;
    if (a.weight != b.weight) return a.weight < b.weight;
    return std::lexicographical_compare(a.place_mm.begin(), a.place_mm.end(), b.place_mm.begin(),
                                        b.place_mm.end());
  });
  summary.max = values.back().value;
  summary.worst_mm = values.back().place_mm;
  if (!(weight > 0)) return summary;
  summary.mean = sum / weight;
  double below = 0;
  for (const WeightedValue& v : values) {
    below += v.weight;
    if (below < 0.95 * weight) continue;
    summary.p95 = v.value;
    break;
  }
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
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      visit(Vec3(a + (b - a) * ((i + 1.0 / 3) / n) + (c - a) * ((j + 1.0 / 3) / n)), weight);
      if (i + j + 1 < n)
        visit(Vec3(a + (b - a) * ((i + 2.0 / 3) / n) + (c - a) * ((j + 2.0 / 3) / n)), weight);
    }
}

}  // namespace lumesh::quality
