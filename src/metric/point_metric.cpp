#include "lumesh/metric/point_metric.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ellipsoid_search.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/metric/point_tree.hpp"

namespace lumesh::metric {

namespace {

/// The metric of places near one another, which often have the same nearest points.
class NeighbourhoodMetrics {
 public:
  NeighbourhoodMetrics(std::span<const Vec3> points, const PointTree& tree, std::size_t k,
                       const EllipsoidOptions& options)
      : points_(points), tree_(tree), search_(options), nearest_(k), gathered_(k) {}

  SymTensor at(const Vec3& place) {
    tree_.nearest(place, nearest_);
    std::sort(nearest_.begin(), nearest_.end());
    std::uint64_t hash = 0;
    for (const std::uint32_t i : nearest_) hash = (hash ^ i) * 0x9E3779B97F4A7C15ull;
    Known& known = known_[hash >> 58];
    if (known.set == nearest_) return known.metric;
    for (std::size_t i = 0; i < nearest_.size(); ++i) gathered_[i] = points_[nearest_[i]];
    known = {nearest_, search_.around(gathered_).metric()};
    return known.metric;
  }

 private:
  struct Known {
    std::vector<std::uint32_t> set;
    SymTensor metric;
  };

  std::span<const Vec3> points_;
  const PointTree& tree_;
  EllipsoidSearch search_;
  std::vector<std::uint32_t> nearest_;
  std::vector<Vec3> gathered_;
  std::array<Known, 64> known_;
};

SymTensor round_metric(double size) {
  const double value = 1 / (size * size);
  return SymTensor::diagonal(value, value, value);
}

}  // namespace

void PointMetricOptions::describe(OptionList& list) {
  list.number("k", k, between(1, 10000), "Points nearest to a vertex that count").needs("points");
  list.flag("isotropic", isotropic,
            "Instead of ellipsoids, sizes that are the same in all directions: the mean distance to these "
            "points (the paper's k is 30 then)")
      .needs("points");
}

void PointMetricOptions::validate() const {
  require_ranges_of(*this);
  if (!(tolerance > 0 && tolerance <= 1 && floor_mm >= 0 && std::isfinite(floor_mm)))
    throw Error(ErrorKind::kUsage, "the tolerance must be above 0 and at most 1, the floor 0 or more");
}

std::vector<SymTensor> metric_from_points(std::span<const Vec3> places, std::span<const Vec3> points,
                                          const PointMetricOptions& options) {
  options.validate();
  const std::vector<Vec3> set = distinct_by_place(points);
  if (set.size() < 2)
    throw Error(ErrorKind::kBadInput,
                set.empty() ? "holds no points" : "all its points are one place; at least two are needed");
  const auto k = static_cast<std::size_t>(options.k);
  require_as_many(set.size(), k);
  if (places.empty()) return {};
  require_near_points(places, set);
  const PointTree tree(set);
  const double floor_mm = options.floor_mm > 0 ? options.floor_mm : median_spacing(set, tree);
  const EllipsoidOptions ellipsoids{options.tolerance, floor_mm};
  std::vector<SymTensor> metric(places.size());
  for_each_along_curve(places, [&] {
    return [&, metrics = NeighbourhoodMetrics(set, tree, k, ellipsoids)](std::uint32_t i) mutable {
      metric[i] = options.isotropic ? round_metric(std::max(tree.mean_distance(places[i], k), floor_mm))
                                    : metrics.at(places[i]);
    };
  });
  return metric;
}

}  // namespace lumesh::metric
