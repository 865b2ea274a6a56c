#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/metric/point_tree.hpp"
#include "nearest_points.hpp"
#include "size_points.hpp"

namespace lumesh {
namespace {

/// Below, refinement does not end in practice: the edge between two corners on opposite sides of a point is
/// as long as both distances together.
constexpr double kEndsByItself = 2;

class PointCriterion final : public Sizing {
 public:
  PointCriterion(std::span<const Vec3> points_mm, const PointCriterionOptions& options)
      : adapt_const_(options.adapt_const),
        points_(points_mm.begin(), points_mm.end()),
        tree_(points_),
        quick_from_mm_(kQuickFrom * options.region_mm.diagonal().norm()),
        quick_(points_, options.region_mm, {quick_from_mm_, kAnySize}) {
    double floor_mm = options.floor_mm;
    if (floor_mm == 0 && adapt_const_ < kEndsByItself && options.bound_mm > 0) {
      floor_mm = options.bound_mm;
      warning_ = fmt::format(
          "{} {:g} is met by no tetrahedra around a point, however small they are, as no value below {:g} "
          "is: edges shorter than {:.3g} mm were left as they are; {} sets that bound",
          option_name("adapt_const"), adapt_const_, kEndsByItself, floor_mm, option_name("size_floor"));
    }
    constexpr double kAtPoint = 1e-3;  // Of the bound: a vertex at the place of a point would ask for ever.
    min_mm_ = std::max(floor_mm / adapt_const_, kAtPoint * options.bound_mm);
  }

  [[nodiscard]] double size_at(const Vec3& /*point_mm*/, Label /*label*/) const override { return kAnySize; }
  [[nodiscard]] bool has_criterion() const override { return true; }
  /// Quick distances are a little too large: they settle most cases.
  [[nodiscard]] bool wants_finer(const std::array<Vec3, 4>& corners_mm) const override {
    constexpr double kSlack = 1 + 2 * delaunay::NearestPoints::kMaxError;
    std::array<double, 4> distances;
    for (std::size_t i = 0; i < 4; ++i) distances[i] = quick_.distance(corners_mm[i]);
    if (*std::ranges::min_element(distances) > quick_from_mm_) {
      const double longest = longest_edge(corners_mm, distances);
      if (longest > adapt_const_ || kSlack * longest < adapt_const_) return longest > adapt_const_;
    }
    for (std::size_t i = 0; i < 4; ++i) distances[i] = distance_at(corners_mm[i]);
    return longest_edge(corners_mm, distances) > adapt_const_;
  }
  [[nodiscard]] std::vector<std::string> warnings() const override {
    return warning_.empty() ? std::vector<std::string>() : std::vector<std::string>{warning_};
  }

 private:
  static constexpr double kQuickFrom = 1e-4;  // Of the region's diagonal.

  [[nodiscard]] double distance_at(const Vec3& x) const {
    std::uint32_t nearest = 0;
    tree_.nearest(x, {&nearest, 1});
    return (points_[nearest] - x).norm();
  }
  /// A corner's metric tensor is 1 / distance^2 times the identity; an edge has the mean of those of its
  /// ends.
  [[nodiscard]] double longest_edge(const std::array<Vec3, 4>& corners,
                                    const std::array<double, 4>& distances) const {
    std::array<double, 4> diagonal;
    for (std::size_t i = 0; i < 4; ++i) {
      const double distance = std::max(distances[i], min_mm_);
      diagonal[i] = 1 / (distance * distance);
    }
    double longest = 0;
    for (const auto& [a, b] : kTetEdges) {
      const double mean = (diagonal[a] + diagonal[b]) / 2;
      longest = std::max(longest, std::sqrt(mean * (corners[a] - corners[b]).squaredNorm()));
    }
    return longest;
  }

  double adapt_const_, min_mm_ = 0;
  std::vector<Vec3> points_;
  metric::PointTree tree_;
  double quick_from_mm_;
  delaunay::NearestPoints quick_;
  std::string warning_;
};

}  // namespace

void PointCriterionOptions::describe(OptionList& list) {
  list.number("adapt_const", adapt_const, above(0),
              "Instead of sizes, the paper's algorithm 3: tetrahedra are refined that have an edge of more "
              "than so many distances from its ends to the nearest of the size_points. size_floor is a "
              "length below which edges stay")
      .zero(fmt::format("{:g} without size_floor and size_k", PointCriterionOptions().adapt_const))
      .needs("size_points")
      .excludes("size_k")
      .excludes("size_factor")
      .excludes("size_ceiling");
}

std::unique_ptr<Sizing> criterion_from_points(std::span<const Vec3> points_mm,
                                              const PointCriterionOptions& options) {
  require_size_points(points_mm);
  require_given_of(options, "adapt_const");
  return std::make_unique<PointCriterion>(points_mm, options);
}

}  // namespace lumesh
