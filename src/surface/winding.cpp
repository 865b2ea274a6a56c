#include "lumesh/surface/winding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh {
namespace {

constexpr double kFar =
    4;  // Reaches from which a node's triangles are one dipole; Barill et al. take 2, with one order more.

/// A sum of angles of complex numbers by one arc tangent: their product has the sum but for full turns.
class AngleSum {
 public:
  void add(const std::complex<double>& number) {
    if (number == 0.0) return;
    const bool is_left = product_.imag() >= 0;
    // Written out: std::complex looks for products that are not finite.
    product_ = {product_.real() * number.real() - product_.imag() * number.imag(),
                product_.real() * number.imag() + product_.imag() * number.real()};
    // Two angles to the same side whose product lies on the other passed half a turn.
    if (is_left == (number.imag() >= 0) && is_left != (product_.imag() >= 0)) turns_ += is_left ? 1 : -1;
    constexpr double kLarge = 1e100, kSmall = 1e-100;
    const double size = std::abs(product_.real()) + std::abs(product_.imag());
    if (size > kLarge || size < kSmall) product_ /= size;
  }
  [[nodiscard]] double sum() const { return std::arg(product_) + 2 * std::numbers::pi * turns_; }

 private:
  std::complex<double> product_ = 1;
  int turns_ = 0;
};

}  // namespace

std::vector<std::array<std::uint32_t, 2>> surfaces::closing_edges(std::span<const Cell<3>> triangles) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> sides) {
    int up = 0;
    for (const TriangleSide& side : sides) up += side.runs_up(triangles[side.triangle]) ? 1 : -1;
    for (; up > 0; --up) edges.push_back({sides[0].high, sides[0].low});
    for (; up < 0; ++up) edges.push_back({sides[0].low, sides[0].high});
  });
  return edges;
}

WindingNumbers::WindingNumbers(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  std::vector<Vec3> middles(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) middles[t] = triangle_centre(points, triangles[t]);
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
      node.moments +=
          (triangle_centre(a, b, c) - node.middle) * (triangle_area_normal(a, b, c) / 2).transpose();
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
  AngleSum near;
  for (std::uint32_t n = 0; n < nodes_.size();) {
    const Node& node = nodes_[n];
    const Vec3 way = node.middle - point;
    const double distance2 = way.squaredNorm();
    if (distance2 > kFar * kFar * node.reach * node.reach) {
      // The triangles' dipoles a . (w + d) / |w + d|^3, d from the node's middle, to first order in d.
      const double first = way.dot(node.area_vector) + node.moments.trace();
      const double second = 3 * way.dot(node.moments * way) / distance2;
      sum += (first - second) / (4 * std::numbers::pi * distance2 * std::sqrt(distance2));
      n = node.next;
      continue;
    }
    if (node.is_leaf())
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        near.add(surfaces::half_view(corners_[i][0], corners_[i][1], corners_[i][2], point));
    ++n;
  }
  return sum + near.sum() / (2 * std::numbers::pi);
}

}  // namespace lumesh
