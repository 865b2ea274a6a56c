#include "flat_triangulation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::surfaces {
namespace {

bool is_in_closed_triangle(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& c) {
  return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && orient2d(c, a, p) >= 0;
}

std::vector<Vec2> all_points(std::span<const Vec2> corners, std::span<const std::vector<Vec2>> holes) {
  std::vector<Vec2> points(corners.begin(), corners.end());
  for (const std::vector<Vec2>& hole : holes) points.insert(points.end(), hole.begin(), hole.end());
  return points;
}

/// Whether a direction from p to x lies strictly within the corner of an anticlockwise outline at p.
bool is_within_corner(const Vec2& before, const Vec2& p, const Vec2& after, const Vec2& x) {
  const bool is_left_of_after = orient2d(p, after, x) > 0, is_right_of_before = orient2d(p, before, x) < 0;
  return orient2d(before, p, after) > 0 ? is_left_of_after && is_right_of_before
                                        : is_left_of_after || is_right_of_before;
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

bool do_segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int abc = orient2d(a, b, c), abd = orient2d(a, b, d), cda = orient2d(c, d, a),
            cdb = orient2d(c, d, b);
  if (abc == 0 && abd == 0)  // On one line: their boxes tell.
    return (a.cwiseMin(b).array() <= c.cwiseMax(d).array()).all() &&
           (c.cwiseMin(d).array() <= a.cwiseMax(b).array()).all();
  return abc * abd <= 0 && cda * cdb <= 0;
}

FlatTriangulation::FlatTriangulation(std::span<const Vec2> corners, std::span<const std::vector<Vec2>> holes)
    : points_(all_points(corners, holes)),
      corner_count_(points_.size()),
      mesh_(cut_off_ears(outline_with_holes(corners.size(), holes))) {}

/// One outline that goes to each hole, around it and back, by the shortest ways that meet no other edge.
std::vector<std::uint32_t> FlatTriangulation::outline_with_holes(
    std::size_t outer, std::span<const std::vector<Vec2>> holes) const {
  std::vector<std::uint32_t> outline(outer);
  std::iota(outline.begin(), outline.end(), 0U);
  std::vector<std::vector<std::uint32_t>> loops;
  auto first = static_cast<std::uint32_t>(outer);
  for (const std::vector<Vec2>& hole : holes) {
    loops.emplace_back(hole.size());
    std::iota(loops.back().begin(), loops.back().end(), first);
    first += static_cast<std::uint32_t>(hole.size());
  }
  while (!loops.empty()) {
    const Bridge bridge = shortest_bridge(outline, loops);
    std::vector<std::uint32_t> loop = loops[bridge.loop];
    loops.erase(loops.begin() + static_cast<std::ptrdiff_t>(bridge.loop));
    std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(bridge.to), loop.end());
    loop.push_back(loop.front());
    loop.push_back(outline[bridge.from]);
    outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(bridge.from) + 1, loop.begin(), loop.end());
  }
  return outline;
}

/// From a corner of the outline to one of a hole.
FlatTriangulation::Bridge FlatTriangulation::shortest_bridge(
    const std::vector<std::uint32_t>& outline, const std::vector<std::vector<std::uint32_t>>& loops) const {
  std::vector<std::pair<double, Bridge>> ways;
  for (std::size_t h = 0; h < loops.size(); ++h)
    for (std::size_t to = 0; to < loops[h].size(); ++to)
      for (std::size_t from = 0; from < outline.size(); ++from)
        ways.push_back({(points_[loops[h][to]] - points_[outline[from]]).squaredNorm(), {from, h, to}});
  std::ranges::stable_sort(ways, [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto corner = [&](const std::vector<std::uint32_t>& loop, std::size_t i) {
    return loop[(i + loop.size()) % loop.size()];
  };
  const auto is_free = [&](const Bridge& way) {
    const std::uint32_t p = outline[way.from], q = loops[way.loop][way.to];
    const auto leaves = [&](const std::vector<std::uint32_t>& loop, std::size_t i, std::uint32_t x) {
      return is_within_corner(points_[corner(loop, i + loop.size() - 1)], points_[loop[i]],
                              points_[corner(loop, i + 1)], points_[x]);
    };
    if (!leaves(outline, way.from, q) || !leaves(loops[way.loop], way.to, p) || meets_edge(outline, p, q))
      return false;
    return std::ranges::none_of(loops, [&](const auto& loop) { return meets_edge(loop, p, q); });
  };
  const auto best = std::ranges::find_if(ways, [&](const auto& way) { return is_free(way.second); });
  LUMESH_ASSERT(best != ways.end());
  return best->second;
}

/// Whether a way between two points meets an edge of a loop that ends at neither of them, or runs along one
/// that does.
bool FlatTriangulation::meets_edge(const std::vector<std::uint32_t>& loop, std::uint32_t p,
                                   std::uint32_t q) const {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t a = loop[i], b = loop[(i + 1) % loop.size()];
    const auto is_end = [&](std::uint32_t v) { return v == p || v == q; };
    if (is_end(a) && is_end(b)) return true;
    if (!is_end(a) && !is_end(b)) {
      if (do_segments_meet(points_[p], points_[q], points_[a], points_[b])) return true;
      continue;
    }
    const std::uint32_t shared = is_end(a) ? a : b, other = is_end(a) ? b : a, end = shared == p ? q : p;
    const Vec2 along = points_[end] - points_[shared], edge = points_[other] - points_[shared];
    if (orient2d(points_[shared], points_[end], points_[other]) == 0 && along.dot(edge) > 0) return true;
  }
  return false;
}

/// Meisters 1975: a simple polygon has two ears. Where the outline passes an edge twice, as to a hole and
/// back, an ear is one whose third edge lies within the outline at both of its ends and meets no other.
std::vector<Cell<3>> FlatTriangulation::cut_off_ears(std::vector<std::uint32_t> left) const {
  std::vector<Cell<3>> triangles;
  const bool is_simple = left.size() == points_.size();
  const auto at = [&](std::size_t i) -> const Vec2& {
    return points_[left[(i + left.size()) % left.size()]];
  };
  const auto is_convex = [&](std::size_t i) {
    return orient2d(at(i + left.size() - 1), at(i), at(i + 1)) > 0;
  };
  const auto is_ear = [&](std::size_t i) {
    if (!is_convex(i)) return false;
    const std::size_t before = i + left.size() - 1, after = i + 1;
    if (!is_simple)
      return is_within_corner(at(before - 1), at(before), at(i), at(after)) &&
             is_within_corner(at(i), at(after), at(after + 1), at(before)) &&
             !meets_edge(left, left[before % left.size()], left[after % left.size()]);
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
