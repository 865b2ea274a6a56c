#include "flat_triangulation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {
namespace {

bool is_in_closed_triangle(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& c) {
  return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0;
}

Vec3 in_space(const Vec2& p) {
  return {p.x(), p.y(), 0};
}

/// Exactly: the sphere through an anticlockwise triangle and any point above it cuts the plane in the
/// triangle's circle.
bool is_in_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  const Vec3 above(a.x(), a.y(), (b - a).norm());
  return insphere(in_space(a), in_space(b), in_space(c), above, in_space(p)) > 0;
}

double largest_cosine(const Vec2& a, const Vec2& b, const Vec2& c) {
  return cosine_of_smallest_angle(in_space(a), in_space(b), in_space(c));
}

}  // namespace

FlatTriangulation::FlatTriangulation(std::span<const Vec2> corners)
    : points_(corners.begin(), corners.end()), corner_count_(corners.size()) {
  cut_off_ears();
  find_neighbours();
}

/// Meisters 1975: a simple polygon has two ears. Corners that are not convex keep an ear from being cut off when
/// they lie on its edge, too, so that no triangle is flat.
void FlatTriangulation::cut_off_ears() {
  std::vector<std::uint32_t> left(corner_count_);
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto at = [&](std::size_t i) -> const Vec2& { return points_[left[(i + left.size()) % left.size()]]; };
  const auto is_convex = [&](std::size_t i) { return orient2d(at(i + left.size() - 1), at(i), at(i + 1)) > 0; };
  const auto is_ear = [&](std::size_t i) {
    if (!is_convex(i)) return false;
    const std::size_t before = i + left.size() - 1, after = i + 1;
    for (std::size_t k = i + 2; k < i + left.size() - 1; ++k)
      if (is_in_closed_triangle(at(k), at(before), at(i), at(after)) && !is_convex(k % left.size())) return false;
    return true;
  };
  std::size_t i = 0;
  for (std::size_t misses = 0; left.size() > 3;) {
    if (is_ear(i)) {
      const std::size_t n = left.size();
      triangles_.push_back({left[(i + n - 1) % n], left[i], left[(i + 1) % n]});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      misses = 0;
      i = (i + 1) % left.size();  // Not the next corner, or ears would make a fan.
    } else {
      i = (i + 1) % left.size();
      LUMESH_ASSERT(++misses <= left.size());
    }
  }
  triangles_.push_back({left[0], left[1], left[2]});
}

void FlatTriangulation::find_neighbours() {
  neighbours_ = edge_neighbours(triangles_);
  static_assert(kNone == kOpenEdge);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) changed_.push_back(t);
}

std::size_t FlatTriangulation::side_towards(std::uint32_t triangle, std::uint32_t other) const {
  for (std::size_t s = 0; s < 2; ++s)
    if (neighbours_[triangle][s] == other) return s;
  return 2;
}

void FlatTriangulation::set(std::uint32_t triangle, const Cell<3>& corners,
                            const std::array<std::uint32_t, 3>& neighbours) {
  triangles_[triangle] = corners;
  neighbours_[triangle] = neighbours;
  changed_.push_back(triangle);
}

bool FlatTriangulation::should_flip(const Side& at) const {
  const std::uint32_t other = neighbours_[at.triangle][at.side];
  if (other == kNone) return false;
  const Vec2& apex = corner(other, side_towards(other, at.triangle) + 2);
  const Vec2 &a = corner(at.triangle, at.side), &b = corner(at.triangle, at.side + 1),
             &c = corner(at.triangle, at.side + 2);
  return is_in_circle(a, b, c, apex) && orient2d(c, a, apex) > 0 && orient2d(apex, b, c) > 0;
}

/// (a, b, c) and (b, a, d) become (c, a, d) and (d, b, c).
void FlatTriangulation::flip(const Side& at, std::vector<Side>& stack) {
  const std::uint32_t t = at.triangle, o = neighbours_[t][at.side];
  const std::size_t s = at.side, r = side_towards(o, t);
  const std::uint32_t a = triangles_[t][s], b = triangles_[t][(s + 1) % 3], c = triangles_[t][(s + 2) % 3],
                      d = triangles_[o][(r + 2) % 3];
  const std::uint32_t over_bc = neighbours_[t][(s + 1) % 3], over_ca = neighbours_[t][(s + 2) % 3];
  const std::uint32_t over_ad = neighbours_[o][(r + 1) % 3], over_db = neighbours_[o][(r + 2) % 3];
  if (over_bc != kNone) neighbours_[over_bc][side_towards(over_bc, t)] = o;
  if (over_ad != kNone) neighbours_[over_ad][side_towards(over_ad, o)] = t;
  set(t, {c, a, d}, {over_ca, over_ad, o});
  set(o, {d, b, c}, {over_db, over_bc, t});
  for (const Side& side : {Side{t, 0}, Side{t, 1}, Side{o, 0}, Side{o, 1}}) stack.push_back(side);
}

void FlatTriangulation::flip_from(std::vector<Side> stack) {
  while (!stack.empty()) {
    const Side at = stack.back();
    stack.pop_back();
    if (should_flip(at)) flip(at, stack);
  }
}

void FlatTriangulation::make_delaunay() {
  std::vector<Side> all;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (const std::size_t s : {0U, 1U, 2U}) all.push_back({t, s});
  flip_from(std::move(all));
}

void FlatTriangulation::insert(const Vec2& point, std::uint32_t triangle) {
  const auto v = static_cast<std::uint32_t>(points_.size());
  const auto second = static_cast<std::uint32_t>(triangles_.size()), third = second + 1;
  points_.push_back(point);
  const auto [a, b, c] = triangles_[triangle];
  const auto [over_ab, over_bc, over_ca] = neighbours_[triangle];
  triangles_.resize(third + 1);
  neighbours_.resize(third + 1);
  if (over_bc != kNone) neighbours_[over_bc][side_towards(over_bc, triangle)] = second;
  if (over_ca != kNone) neighbours_[over_ca][side_towards(over_ca, triangle)] = third;
  set(triangle, {a, b, v}, {over_ab, second, third});
  set(second, {b, c, v}, {over_bc, third, triangle});
  set(third, {c, a, v}, {over_ca, triangle, second});
  flip_from({{triangle, 0}, {second, 0}, {third, 0}});
}

std::optional<std::uint32_t> FlatTriangulation::locate(const Vec2& point, std::uint32_t from) const {
  std::uint32_t at = from, before = kNone;
  for (std::size_t steps = 0; steps <= triangles_.size(); ++steps) {
    std::size_t out = 3;
    for (std::size_t s = 0; s < 3 && out == 3; ++s) {
      if (neighbours_[at][s] == before && before != kNone) continue;
      const int side = orient2d(corner(at, s), corner(at, s + 1), point);
      if (side == 0) return std::nullopt;
      if (side < 0) out = s;
    }
    if (out == 3) return at;
    before = std::exchange(at, neighbours_[at][out]);
    if (at == kNone) return std::nullopt;
  }
  return std::nullopt;
}

void FlatTriangulation::smooth() {
  std::vector<std::vector<std::uint32_t>> around(points_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (const std::uint32_t v : triangles_[t])
      if (v >= corner_count_) around[v].push_back(t);
  for (auto v = static_cast<std::uint32_t>(corner_count_); v < points_.size(); ++v) {
    const auto worst_cosine = [&] {
      double worst = -1;
      for (const std::uint32_t t : around[v]) {
        if (orient2d(corner(t, 0), corner(t, 1), corner(t, 2)) <= 0) return 2.0;
        worst = std::max(worst, largest_cosine(corner(t, 0), corner(t, 1), corner(t, 2)));
      }
      return worst;
    };
    Vec2 middle = Vec2::Zero();
    for (const std::uint32_t t : around[v])
      for (const std::uint32_t w : triangles_[t])
        if (w != v) middle += points_[w] / (2 * static_cast<double>(around[v].size()));
    const double before = worst_cosine();
    const Vec2 old = std::exchange(points_[v], middle);
    if (!(worst_cosine() < before)) points_[v] = old;
  }
}

}  // namespace lumesh::surfaces
