#include "lumesh/metric/point_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <tuple>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

namespace {

/// The nearest points so far, by distance and index, where nanoflann's own keeps the one it meets first.
class NearestFirst {
 public:
  using DistanceType = double;

  explicit NearestFirst(std::span<std::uint32_t> indices)
      : indices_(indices), squares_(indices.size(), std::numeric_limits<double>::infinity()) {}

  [[nodiscard]] bool full() const { return count_ == indices_.size(); }
  /// The search passes on what is less: the next number lets points in that are as near as the last.
  [[nodiscard]] double worstDist() const {
    return std::nextafter(squares_.back(), std::numeric_limits<double>::infinity());
  }
  bool addPoint(double square, std::uint32_t index) {
    const auto is_before = [&](std::size_t i) {
      return std::tie(square, index) < std::tie(squares_[i], indices_[i]);
    };
    if (full() && !is_before(count_ - 1)) return true;
    std::size_t at = full() ? count_ - 1 : count_++;
    for (; at > 0 && is_before(at - 1); --at) {
      squares_[at] = squares_[at - 1];
      indices_[at] = indices_[at - 1];
    }
    squares_[at] = square;
    indices_[at] = index;
    return true;
  }

 private:
  std::span<std::uint32_t> indices_;
  std::vector<double> squares_;
  std::size_t count_ = 0;
};

std::string text_of(const Box3& box) {
  return coordinates_text(box.min(), 4) + " to " + coordinates_text(box.max(), 4);
}

}  // namespace

struct PointTree::Index {
  /// The points as nanoflann asks for them.
  struct Table {
    std::span<const Vec3> points;

    [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
    [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points[i][static_cast<Eigen::Index>(axis)];
    }
    template <class Bounds>
    bool kdtree_get_bbox(Bounds& /*bounds*/) const {
      return false;
    }
  };
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Table>, Table, 3,
                                                   std::uint32_t>;

  explicit Index(std::span<const Vec3> points) : table{points}, tree(3, table, {10}) { tree.buildIndex(); }

  Table table;
  Tree tree;
};

PointTree::PointTree(std::span<const Vec3> points) : index_(std::make_unique<const Index>(points)) {}

PointTree::~PointTree() = default;

void PointTree::nearest(const Vec3& place, std::span<std::uint32_t> out) const {
  LUMESH_ASSERT(!out.empty() && out.size() <= index_->table.points.size());
  NearestFirst found(out);
  index_->tree.findNeighbors(found, place.data(), nanoflann::SearchParams());
}

double PointTree::mean_distance(const Vec3& place, std::size_t k) const {
  std::vector<std::uint32_t> nearest_points(k);
  nearest(place, nearest_points);
  double sum = 0;
  for (const std::uint32_t i : nearest_points) sum += (index_->table.points[i] - place).norm();
  return sum / static_cast<double>(k);
}

void require_as_many(std::size_t count, std::size_t k) {
  if (k > count)
    throw Error(ErrorKind::kBadInput,
                fmt::format("has only {} different points, k asks for {}; lower k", count, k));
}

std::vector<Vec3> distinct_by_place(std::span<const Vec3> points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw Error(ErrorKind::kBadInput, fmt::format("point {}, counted from 0, is not finite", i));
  std::vector<Vec3> sorted(points.begin(), points.end());
  for (Vec3& p : sorted) p += Vec3::Zero();  // -0 becomes 0: equal points have the same bits.
  parallel::sort_unique(sorted, [](const Vec3& a, const Vec3& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  });
  return sorted;
}

double median_spacing(std::span<const Vec3> points, const PointTree& tree) {
  std::vector<double> spacings(points.size());
  parallel::for_each_index(points.size(), [&](std::size_t i) {
    std::array<std::uint32_t, 2> pair{};  // The point itself and its nearest.
    tree.nearest(points[i], pair);
    spacings[i] = (points[pair[1]] - points[pair[0]]).norm();
  });
  const std::size_t middle = spacings.size() / 2;
  return value_of_rank(std::move(spacings), middle);
}

void require_near_points(std::span<const Vec3> places, std::span<const Vec3> points) {
  const Box3 box = bounding_box(places);
  const double reach = box.sizes().norm();
  const bool is_near = std::ranges::any_of(
      points, [&](const Vec3& p) { return box.squaredExteriorDistance(p) <= reach * reach; });
  // Many points fill what they are of, at least in part: so small or large a box is that of metres beside
  // millimetres.
  constexpr std::size_t kMany = 100;
  constexpr double kOtherUnit = 500;
  const double extent = bounding_box(points).sizes().norm();
  const bool has_other_unit =
      reach > 0 && points.size() >= kMany && (extent * kOtherUnit < reach || extent > kOtherUnit * reach);
  if (is_near && !has_other_unit) return;
  throw Error(ErrorKind::kBadInput, fmt::format("{}, {} against {}; check unit and frame of both",
                                                is_near ? "the points have another unit than the mesh"
                                                        : "all points lie far from the mesh",
                                                text_of(bounding_box(points)), text_of(box)));
}

}  // namespace lumesh::metric
