#include "grid_sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

constexpr double kHalfInside = 0.5;  // Winding number.

/// Directed edges that close a surface: as often as its triangles run each edge one way more than the other,
/// the other way.
std::vector<std::array<std::uint32_t, 2>> closing_edges(std::span<const Cell<3>> triangles) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> sides) {
    int up = 0;
    for (const TriangleSide& side : sides) up += side.runs_up(triangles[side.triangle]) ? 1 : -1;
    for (; up > 0; --up) edges.push_back({sides[0].high, sides[0].low});
    for (; up < 0; ++up) edges.push_back({sides[0].low, sides[0].high});
  });
  return edges;
}

}  // namespace

/// Each connected part of the closing edges is a cone's rim, as each of their ends is a beginning, too.
GridSides::ClosedByCones::ClosedByCones(const TriangleMesh& given, const PointGrid& grid)
    : triangles(given.triangles), given_count(given.triangles.size()) {
  for (const Vec3& p : given.points) points.emplace_back((p - grid.origin_mm) / grid.spacing_mm);
  const std::vector<std::array<std::uint32_t, 2>> edges = closing_edges(given.triangles);
  DisjointSets sets(points.size());
  for (const auto& [from, to] : edges) sets.merge(from, to);
  std::map<std::uint32_t, std::uint32_t> apex_of;
  std::vector<double> ends;
  const std::size_t first = points.size();
  for (const auto& edge : edges) {
    const auto [found, is_new] =
        apex_of.try_emplace(sets.find(edge[0]), static_cast<std::uint32_t>(points.size()));
    const Vec3 start = points[edge[0]];
    if (is_new) {
      points.push_back(Vec3::Zero());
      ends.push_back(0);
      cone_boxes.emplace_back(start, start);
    }
    const std::size_t cone = found->second - first;
    points[found->second] += start;
    ends[cone] += 1;
    cone_boxes[cone] = {cone_boxes[cone].first.cwiseMin(start), cone_boxes[cone].second.cwiseMax(start)};
    triangles.push_back({edge[0], edge[1], found->second});
  }
  for (std::size_t cone = 0; cone < ends.size(); ++cone) points[first + cone] /= ends[cone];
}

GridSides::GridSides(const TriangleMesh& given, const PointGrid& grid)
    : size_(grid.size),
      closed_(given, grid),
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
