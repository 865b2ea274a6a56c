#include "flat_triangulation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/adjacency.hpp"

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
    : points_(corners.begin(), corners.end()), corner_count_(corners.size()), mesh_(cut_off_ears()) {}

/// Meisters 1975: a simple polygon has two ears. Corners that are not convex keep an ear from being cut off
/// when they lie on its edge, too, so that no triangle is flat.
std::vector<Cell<3>> FlatTriangulation::cut_off_ears() const {
  std::vector<Cell<3>> triangles;
  std::vector<std::uint32_t> left(corner_count_);
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto at = [&](std::size_t i) -> const Vec2& {
    return points_[left[(i + left.size()) % left.size()]];
  };
  const auto is_convex = [&](std::size_t i) {
    return orient2d(at(i + left.size() - 1), at(i), at(i + 1)) > 0;
  };
  const auto is_ear = [&](std::size_t i) {
    if (!is_convex(i)) return false;
    const std::size_t before = i + left.size() - 1, after = i + 1;
    for (std::size_t k = i + 2; k < i + left.size() - 1; ++k)
      if (is_in_closed_triangle(at(k), at(before), at(i), at(after)) && !is_convex(k % left.size()))
        return false;
    return true;
  };
  std::size_t i = 0;
  for (std::size_t misses = 0; left.size() > 3;) {
    if (is_ear(i)) {
      const std::size_t n = left.size();
      triangles.push_back({left[(i + n - 1) % n], left[i], left[(i + 1) % n]});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      misses = 0;
      i = (i + 1) % left.size();  // Not the next corner, or ears would make a fan.
    } else {
      i = (i + 1) % left.size();
      LUMESH_ASSERT(++misses <= left.size());
    }
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

bool FlatTriangulation::should_flip(const Side& at) const {
  if (mesh_.neighbour(at) == FlippableTriangles::kNone) return false;
  const Vec2 &a = points_[mesh_.vertex(at, 0)], &b = points_[mesh_.vertex(at, 1)],
             &c = points_[mesh_.vertex(at, 2)], &apex = points_[mesh_.vertex_across(at)];
  return is_in_circle(a, b, c, apex) && orient2d(c, a, apex) > 0 && orient2d(apex, b, c) > 0;
}

void FlatTriangulation::flip_from(std::vector<Side> stack) {
  while (!stack.empty()) {
    const Side at = stack.back();
    stack.pop_back();
    if (!should_flip(at)) continue;
    const auto around = mesh_.flip(at);
    stack.insert(stack.end(), around.begin(), around.end());
  }
}

void FlatTriangulation::make_delaunay() {
  flip_from(mesh_.sides());
}

void FlatTriangulation::insert(const Vec2& point, std::uint32_t triangle) {
  const auto vertex = static_cast<std::uint32_t>(points_.size());
  points_.push_back(point);
  const auto around = mesh_.split(triangle, vertex);
  flip_from({around.begin(), around.end()});
}

std::optional<std::uint32_t> FlatTriangulation::locate(const Vec2& point, std::uint32_t from) const {
  std::uint32_t at = from, before = FlippableTriangles::kNone;
  for (std::size_t steps = 0; steps <= triangles().size(); ++steps) {
    std::size_t out = 3;
    for (std::size_t s = 0; s < 3 && out == 3; ++s) {
      if (before != FlippableTriangles::kNone && mesh_.neighbour({at, s}) == before) continue;
      const int side = orient2d(corner(at, s), corner(at, s + 1), point);
      if (side == 0) return std::nullopt;
      if (side < 0) out = s;
    }
    if (out == 3) return at;
    before = std::exchange(at, mesh_.neighbour({at, out}));
    if (at == FlippableTriangles::kNone) return std::nullopt;
  }
  return std::nullopt;
}

void FlatTriangulation::smooth() {
  const parallel::Adjacency around = parallel::cells_around(triangles(), points_.size());
  for (auto v = static_cast<std::uint32_t>(corner_count_); v < points_.size(); ++v) {
    const auto worst_cosine = [&] {
      double worst = -1;
      for (const std::uint32_t t : around.of(v)) {
        if (orient2d(corner(t, 0), corner(t, 1), corner(t, 2)) <= 0) return 2.0;
        worst = std::max(worst, largest_cosine(corner(t, 0), corner(t, 1), corner(t, 2)));
      }
      return worst;
    };
    Vec2 middle = Vec2::Zero();
    for (const std::uint32_t t : around.of(v))
      for (const std::uint32_t w : triangles()[t])
        if (w != v) middle += points_[w] / (2 * static_cast<double>(around.of(v).size()));
    const double before = worst_cosine();
    const Vec2 old = std::exchange(points_[v], middle);
    if (!(worst_cosine() < before)) points_[v] = old;
  }
}

}  // namespace lumesh::surfaces
