#include "grid_sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

constexpr double kHalfInside = 0.5;  // Winding number.

/// Points in steps of a grid.
std::vector<Vec3> in_steps(std::span<const Vec3> points, const PointGrid& grid) {
  std::vector<Vec3> steps;
  steps.reserve(points.size());
  for (const Vec3& p : points) steps.emplace_back((p - grid.origin_mm) / grid.spacing_mm);
  return steps;
}

}  // namespace

GridSides::GridSides(const TriangleMesh& given, const PointGrid& grid)
    : size_(grid.size),
      closed_(in_steps(given.points, grid), given.triangles),
      cones_(closed_.points, closed_.cones()),
      hits_{RowHits(closed_.points, closed_.triangles, size_, 0),
            RowHits(closed_.points, closed_.triangles, size_, 1),
            RowHits(closed_.points, closed_.triangles, size_, 2)},
      is_inside_(grid_count(grid.size), 0) {
  if (!closed_.cones().empty()) find_blocks_far_from_cones();
  parallel::for_each_index(grid_row_count(size_), 16, [&](std::size_t row) { fill_row(row); });
}

void GridSides::find_blocks_far_from_cones() {
  blocks_ = (size_.array() + kBlock - 1) / kBlock;
  of_block_.assign(grid_count(blocks_), 0);
  for (const auto& [low, high] : closed_.cone_boxes) {
    const double reach = (high - low).norm() + kBlock;
    const auto nearest_block = [&](const Vec3& p) {
      return nearest_place(blocks_, (p / kBlock).array().floor().matrix().cast<int>());
    };
    for_each_place(nearest_block(low - Vec3::Constant(reach)), nearest_block(high + Vec3::Constant(reach)),
                   [&](const Index3& block) {
                     of_block_[grid_offset(blocks_, block)] = std::numeric_limits<float>::quiet_NaN();
                   });
  }
  parallel::for_each_index(of_block_.size(), 16, [&](std::size_t b) {
    const Vec3 middle = kBlock * (grid_place(blocks_, b).cast<double>() + Vec3::Constant(0.5));
    if (!std::isnan(of_block_[b])) of_block_[b] = static_cast<float>(cones_.at(middle));
  });
}

std::size_t GridSides::block_of(const Index3& place) const {
  return grid_offset(blocks_, place / kBlock);
}

double GridSides::cone_winding(const Index3& place) const {
  if (of_block_.empty()) return 0;
  const float of_block = of_block_[block_of(place)];
  return std::isnan(of_block) ? cones_.at(place.cast<double>()) : of_block;
}

void GridSides::fill_row(std::size_t row) {
  Index3 place = grid_row(size_, row);
  const std::span<const RowHit> hits = hits_[0].through(place);
  int winding = 0;
  auto hit = hits.begin();
  for (; place.x() < size_.x(); ++place.x()) {
    for (; hit != hits.end() && hit->at < place.x(); ++hit) winding += hit->growth;
    is_inside_[grid_offset(size_, place)] = winding - cone_winding(place) > kHalfInside ? 1 : 0;
  }
}

double GridSides::winding(const Index3& place, int axis) const {
  double winding = -cone_winding(place);
  for (const RowHit& hit : hits_[static_cast<std::size_t>(axis)].through(place)) {
    if (hit.at >= place[axis]) break;
    winding += hit.growth;
  }
  return winding;
}

GridSides::Crossing GridSides::crossing(const Index3& place, int axis) const {
  const double from = place[axis];
  const bool is_from_inside = is_inside(grid_offset(size_, place));
  double before = winding(place, axis);
  for (const RowHit& hit : hits_[static_cast<std::size_t>(axis)].through(place)) {
    if (hit.at < from || hit.triangle >= closed_.given_count) continue;
    if (hit.at > from + 1) break;
    const double after = before + hit.growth;
    if ((before > kHalfInside) == is_from_inside && (after > kHalfInside) != is_from_inside)
      return {hit.at - from, hit.triangle};
    before = after;
  }
  // In a hole, or where a place lies on the surface but for rounding.
  Index3 next = place;
  ++next[axis];
  const double at_place = winding(place, axis), at_next = winding(next, axis);
  const double share = at_place != at_next ? (at_place - kHalfInside) / (at_place - at_next) : kHalfInside;
  return {std::clamp(share, 0.0, 1.0), TriangleTree::kNone};
}

}  // namespace lumesh::surfaces
