#include "phantom_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace lumesh::image {

double Torus::distance(const Vec3& p) const {
  const Vec3 d = p - centre_;
  return std::hypot(std::hypot(d.x(), d.y()) - ring_radius_, d.z()) - tube_radius_;
}

double RoundedBox::distance(const Vec3& p) const {
  const Vec3 beyond = (p - centre_).cwiseAbs() - inner_half_;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0) - radius_;
}

double Union::distance(const Vec3& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const ShapePointer& part : parts_) nearest = std::min(nearest, part->distance(p));
  return nearest;
}

TubeTree::TubeTree(const std::vector<std::vector<AxisPoint>>& axes) {
  for (const std::vector<AxisPoint>& axis : axes) add_axis(axis);
  nodes_.reserve(cones_.size());
  build(0, static_cast<std::uint32_t>(cones_.size()));
}

void TubeTree::add_axis(const std::vector<AxisPoint>& axis) {
  for (std::size_t i = 0; i + 1 < axis.size(); ++i) {
    const Vec3 along = axis[i + 1].centre - axis[i].centre;
    const double length = along.norm();
    if (length == 0) continue;
    const double slope = std::clamp((axis[i].radius - axis[i + 1].radius) / length, -0.99, 0.99);
    cones_.push_back({axis[i].centre, along / length, length, axis[i].radius, slope,
                      slope / std::sqrt(1 - slope * slope)});
  }
}

std::uint32_t TubeTree::build(std::uint32_t first, std::uint32_t last) {
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.low.setConstant(std::numeric_limits<double>::infinity());
  node.high = -node.low;
  for (std::uint32_t c = first; c < last; ++c) {
    const Cone& cone = cones_[c];
    const Vec3 end = cone.start + cone.axis * cone.length;
    node.low = node.low.cwiseMin(cone.start).cwiseMin(end);
    node.high = node.high.cwiseMax(cone.start).cwiseMax(end);
    node.radius = std::max({node.radius, cone.radius, cone.radius - cone.slope * cone.length});
  }
  node.first = first;
  node.last = last;
  nodes_.push_back(node);
  if (last - first > kLeafCones) {
    const std::uint32_t middle =
        first + (last - first) / 2;  // neighbours along an axis are neighbours in space
    build(first, middle);
    nodes_[at].second_child = build(middle, last);
  }
  return at;
}

/// The ball centred at t along the axis is |(x - t, y)| - (radius - slope t) away; that is convex in t, so
/// its minimum over the segment is the free minimum clamped to it.
double TubeTree::cone_distance(const Cone& cone, const Vec3& p) {
  const Vec3 d = p - cone.start;
  const double x = d.dot(cone.axis);
  const double y_squared = std::max(0.0, d.squaredNorm() - x * x);
  const double t = std::clamp(x - cone.slope_shift * std::sqrt(y_squared), 0.0, cone.length);
  return std::sqrt((x - t) * (x - t) + y_squared) - (cone.radius - cone.slope * t);
}

double TubeTree::lower_bound(const Node& node, const Vec3& p) {
  return (node.low - p).cwiseMax(p - node.high).cwiseMax(0.0).norm() - node.radius;
}

double TubeTree::distance(const Vec3& p) const {
  struct Entry {
    std::uint32_t node;
    double bound;
  };
  std::array<Entry, 64> stack;  // the tree halves its cones, so 64 levels are never reached
  std::size_t depth = 0;
  double nearest = std::numeric_limits<double>::infinity();
  stack[depth++] = {0, -nearest};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.bound >= nearest) continue;
    const Node& node = nodes_[entry.node];
    if (node.second_child == 0) {
      for (std::uint32_t c = node.first; c < node.last; ++c)
        nearest = std::min(nearest, cone_distance(cones_[c], p));
      continue;
    }
    Entry near = {entry.node + 1, lower_bound(nodes_[entry.node + 1], p)};
    Entry far = {node.second_child, lower_bound(nodes_[node.second_child], p)};
    if (far.bound < near.bound) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return nearest;
}

std::vector<Vec3> sample_spline(const std::vector<Vec3>& controls, double step_mm) {
  std::vector<Vec3> points;
  for (std::size_t s = 0; s + 3 < controls.size(); ++s) {
    const auto at = [&](double t) -> Vec3 {
      const double u = 1 - t;
      return (u * u * u * controls[s] + (3 * t * t * t - 6 * t * t + 4) * controls[s + 1] +
              (3 * u * u * u - 6 * u * u + 4) * controls[s + 2] + t * t * t * controls[s + 3]) /
             6.0;
    };
    double longest = 0;  // speed is at most the longest leg of the control polygon
    for (std::size_t leg = s; leg < s + 3; ++leg)
      longest = std::max(longest, (controls[leg + 1] - controls[leg]).norm());
    const int steps = std::max(1, static_cast<int>(std::ceil(longest / step_mm)));
    if (points.empty()) points.push_back(at(0));
    for (int i = 1; i <= steps; ++i) points.push_back(at(static_cast<double>(i) / steps));
  }
  return points;
}

WaveNoise::WaveNoise(std::uint32_t seed, double unit_mm) {
  constexpr int kWaves = 6;
  std::mt19937 random(seed);  // its sequence is fixed by the standard; distributions are not, so none is used
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int w = 0; w < kWaves; ++w) {
    const double z = 2 * uniform() - 1;
    const double turn = 2 * std::numbers::pi * uniform();
    const double across = std::sqrt(1 - z * z);
    const double wavelength_mm = (16 + 16 * uniform()) * unit_mm;
    waves_.push_back(
        {Vec3(across * std::cos(turn), across * std::sin(turn), z) * (2 * std::numbers::pi / wavelength_mm),
         2 * std::numbers::pi * uniform()});
  }
}

double WaveNoise::at(const Vec3& p) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::sin(wave.frequency.dot(p) + wave.phase);
  return sum / static_cast<double>(waves_.size());
}

}  // namespace lumesh::image
