#include "lumesh/surface/winding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <numeric>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh {
namespace {

constexpr double kFar =
    4;  // Reaches from which a node's triangles are one dipole; Barill et al. take 2, with one order more.

}  // namespace

WindingNumbers::WindingNumbers(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  std::vector<Vec3> middles(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    middles[t] = (points[triangles[t][0]] + points[triangles[t][1]] + points[triangles[t][2]]) / 3;
  std::vector<std::uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  if (!order.empty()) build(order, 0, middles);
  for (const std::uint32_t t : order)
    corners_.push_back({points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]]});
  for (Node& node : nodes_) {
    double area = 0;
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const auto& [a, b, c] = corners_[i];
      const Vec3 vector = triangle_area_normal(a, b, c) / 2;
      node.area_vector += vector;
      node.middle += vector.norm() * (a + b + c) / 3;
      area += vector.norm();
    }
    node.middle = area > 0 ? Vec3(node.middle / area) : corners_[node.begin][0];
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const auto& [a, b, c] = corners_[i];
      node.moments += ((a + b + c) / 3 - node.middle) * (triangle_area_normal(a, b, c) / 2).transpose();
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      for (const Vec3& corner : corners_[i]) node.reach = std::max(node.reach, (corner - node.middle).norm());
  }
}

/// Halves what lies in `order` along the longest axis of the triangles' middles.
void WindingNumbers::build(std::span<std::uint32_t> order, std::uint32_t begin,
                           std::span<const Vec3> middles) {
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  nodes_[at].begin = begin;
  nodes_[at].end = begin + static_cast<std::uint32_t>(order.size());
  if (!nodes_[at].is_leaf()) {
    Box3 box;
    for (const std::uint32_t t : order) box.extend(middles[t]);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::size_t half = order.size() / 2;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis]
                                                                   : a < b;
                     });
    build(order.first(half), begin, middles);
    build(order.subspan(half), begin + static_cast<std::uint32_t>(half), middles);
  }
  nodes_[at].next = static_cast<std::uint32_t>(nodes_.size());
}

double WindingNumbers::at(const Vec3& point) const {
  double sum = 0;
  for (std::uint32_t n = 0; n < nodes_.size();) {
    const Node& node = nodes_[n];
    const Vec3 way = node.middle - point;
    const double distance = way.norm();
    if (distance > kFar * node.reach) {
      // The triangles' dipoles a . (w + d) / |w + d|^3, d from the node's middle, to first order in d.
      const double first = way.dot(node.area_vector) + node.moments.trace();
      const double second = 3 * way.dot(node.moments * way) / (distance * distance);
      sum += (first - second) / (4 * std::numbers::pi * distance * distance * distance);
      n = node.next;
      continue;
    }
    if (node.is_leaf())
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        sum += surfaces::share_of_view(corners_[i][0], corners_[i][1], corners_[i][2], point);
    ++n;
  }
  return sum;
}

}  // namespace lumesh
