#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/metric/point_tree.hpp"

namespace lumesh {
namespace {

/// The points of axes whose radii are alike, within a factor of kRatio.
class PointsOfARadius {
 public:
  static constexpr double kRatio = 1.25;

  PointsOfARadius(std::vector<Vec3> points, std::vector<double> radii_mm)
      : points_(std::move(points)), radii_mm_(std::move(radii_mm)), tree_(points_) {}

  struct Nearest {
    double radii = std::numeric_limits<double>::infinity();  ///< How many of its radii it is away.
    double radius_mm = 0;
  };
  [[nodiscard]] Nearest nearest(const Vec3& x) const {
    std::uint32_t at = 0;
    tree_.nearest(x, {&at, 1});
    return {(points_[at] - x).norm() / radii_mm_[at], radii_mm_[at]};
  }

 private:
  std::vector<Vec3> points_;
  std::vector<double> radii_mm_;
  metric::PointTree tree_;
};

/// By the axis that is the fewest of its radii away: where a thin branch begins, within its parent, the
/// parent counts.
class AxisSizing final : public Sizing {
 public:
  AxisSizing(const Polylines& axes, double cells_per_diameter) : per_radius_(2 / cells_per_diameter) {
    std::map<int, std::pair<std::vector<Vec3>, std::vector<double>>> of_radius;
    const std::vector<double>& radii_mm = axes.scalars.at("radius");
    for (std::size_t i = 0; i < axes.points.size(); ++i) {
      auto& [points, radii] =
          of_radius[static_cast<int>(std::floor(std::log(radii_mm[i]) / std::log(PointsOfARadius::kRatio)))];
      points.push_back(axes.points[i]);
      radii.push_back(radii_mm[i]);
    }
    for (auto& [number, group] : of_radius)
      groups_.push_back(std::make_unique<PointsOfARadius>(std::move(group.first), std::move(group.second)));
  }

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    PointsOfARadius::Nearest best;
    for (const auto& group : groups_)
      if (const PointsOfARadius::Nearest found = group->nearest(point_mm); found.radii < best.radii)
        best = found;
    return per_radius_ * best.radius_mm;
  }

 private:
  double per_radius_;
  std::vector<std::unique_ptr<const PointsOfARadius>> groups_;
};

}  // namespace

void describe_cells_per_diameter(OptionList& list, double& cells) {
  list.number("cells_per_diameter", cells, between(1, 25),
              "About so many edges along the diameter of each vessel, or more where the edge length is "
              "shorter. The diameter is that of the axis that is the fewest of its radii away: a sac gets "
              "the size of its vessel")
      .zero("none");
}

std::unique_ptr<Sizing> size_from_axes(const Polylines& axes, double cells_per_diameter) {
  OptionList list;
  describe_cells_per_diameter(list, cells_per_diameter);
  require_given(list, "cells_per_diameter");
  const auto radii = axes.scalars.find("radius");
  const bool are_good =
      radii != axes.scalars.end() && !axes.points.empty() && radii->second.size() == axes.points.size() &&
      std::ranges::all_of(radii->second, [](double r) { return r > 0 && std::isfinite(r); });
  if (!are_good)
    throw Error(ErrorKind::kBadInput, "axes for cells per diameter need points with a radius greater than 0");
  return std::make_unique<AxisSizing>(axes, cells_per_diameter);
}

}  // namespace lumesh
