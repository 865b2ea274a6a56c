#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/built_in_sizings.hpp"

namespace lumesh {
namespace {

/// As nanoflann wants to see points.
struct AxisPoints {
  const std::vector<Vec3>* points;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points->size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return (*points)[i][static_cast<int>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

class AxisSizing final : public Sizing {
 public:
  AxisSizing(const Polylines& axes, double cells_per_diameter)
      : points_(axes.points), adaptor_{&points_}, tree_(3, adaptor_) {
    for (const double radius_mm : axes.scalars.at("radius"))
      sizes_mm_.push_back(2 * radius_mm / cells_per_diameter);
  }

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    std::uint32_t nearest = 0;
    double square = 0;
    tree_.knnSearch(point_mm.data(), 1, &nearest, &square);
    return sizes_mm_[nearest];
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, AxisPoints>,
                                                   AxisPoints, 3, std::uint32_t>;
  std::vector<Vec3> points_;
  std::vector<double> sizes_mm_;
  AxisPoints adaptor_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<Sizing> size_from_axes(const Polylines& axes, double cells_per_diameter) {
  if (!(cells_per_diameter > 0) || !std::isfinite(cells_per_diameter))
    throw Error(ErrorKind::kUsage,
                fmt::format("the cells per diameter must be a finite number greater than 0, not {:g}",
                            cells_per_diameter));
  const auto radii = axes.scalars.find("radius");
  const bool are_good = radii != axes.scalars.end() && !axes.points.empty() &&
                        radii->second.size() == axes.points.size() &&
                        std::all_of(radii->second.begin(), radii->second.end(),
                                    [](double r) { return r > 0 && std::isfinite(r); });
  if (!are_good)
    throw Error(ErrorKind::kBadInput, "axes for cells per diameter need points with a radius greater than 0");
  return std::make_unique<AxisSizing>(axes, cells_per_diameter);
}

}  // namespace lumesh
