#include "lumesh/surface/planar_patch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "flat_triangulation.hpp"

namespace lumesh::surfaces {
namespace {

/// Circle around a triangle.
struct Circle {
  Vec2 centre;
  double radius;
};
Circle circle_around(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  const double twice = 2 * (u.x() * v.y() - u.y() * v.x());
  const Vec2 off((v.y() * u.squaredNorm() - u.y() * v.squaredNorm()) / twice,
                 (u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) / twice);
  return {a + off, off.norm()};
}

/// Puts points into circumcentres, the largest circles first.
class Refinement {
 public:
  Refinement(FlatTriangulation& triangulation, std::vector<double> sizes)
      : mesh_(triangulation), sizes_(std::move(sizes)) {}

  void run() {
    for (;;) {
      for (const std::uint32_t t : mesh_.take_changed()) offer(t);
      if (queue_.empty()) return;
      const Candidate candidate = queue_.top();
      queue_.pop();
      if (mesh_.triangles()[candidate.triangle] == candidate.corners) try_to_split(candidate);
    }
  }

 private:
  struct Candidate {
    double ratio;
    std::uint32_t triangle;
    Cell<3> corners;
    bool operator<(const Candidate& other) const {
      return ratio != other.ratio ? ratio < other.ratio : corners < other.corners;
    }
  };
  /// Largest radius of circles: an equilateral triangle with edges of the size has 0.58.
  static constexpr double kMaxRadius = 0.75;
  /// New points keep this far from others, in sizes.
  static constexpr double kMinApart = 0.6;

  [[nodiscard]] double size_of(const Cell<3>& corners) const {
    return (sizes_[corners[0]] + sizes_[corners[1]] + sizes_[corners[2]]) / 3;
  }
  [[nodiscard]] Circle circle_of(std::uint32_t t) const {
    return circle_around(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2));
  }
  void offer(std::uint32_t t) {
    const double ratio = circle_of(t).radius / size_of(mesh_.triangles()[t]);
    if (ratio > kMaxRadius && std::isfinite(ratio)) queue_.push({ratio, t, mesh_.triangles()[t]});
  }
  void try_to_split(const Candidate& candidate) {
    const Vec2 centre = circle_of(candidate.triangle).centre;
    const auto within = mesh_.locate(centre, candidate.triangle);
    if (!within) return;
    const Cell<3>& corners = mesh_.triangles()[*within];
    const double size = size_of(corners);
    for (std::size_t i = 0; i < 3; ++i) {
      if ((mesh_.corner(*within, i) - centre).norm() < kMinApart * size) return;
      // Nor so near to an edge of the polygon that a flat triangle stands on it.
      const Vec2 &a = mesh_.corner(*within, i), &b = mesh_.corner(*within, i + 1);
      if (mesh_.is_border(*within, i) && (a - centre).dot(b - centre) < 0) return;
    }
    sizes_.push_back(size);
    mesh_.insert(centre, *within);
  }

  FlatTriangulation& mesh_;
  std::vector<double> sizes_;  // Wanted edge length at each point.
  std::priority_queue<Candidate> queue_;
};

/// Adds the mean of the two edges at each corner.
void append_sizes(std::span<const Vec2> corners, std::vector<double>& all) {
  std::vector<double> sizes(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& next = corners[(i + 1) % corners.size()];
    const double half = (next - corners[i]).norm() / 2;
    sizes[i] += half;
    sizes[(i + 1) % corners.size()] += half;
  }
  all.insert(all.end(), sizes.begin(), sizes.end());
}

double doubled_area(std::span<const Vec2> corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice;
}

/// Whether a hole lies within a polygon, no edge of it meeting one of the polygon or of another hole.
bool is_hole_of(std::span<const Vec2> corners, std::span<const std::vector<Vec2>> holes, std::size_t which) {
  const std::vector<Vec2>& hole = holes[which];
  if (!is_simple_polygon(hole) || doubled_area(hole) >= 0 || !is_inside(corners, hole[0])) return false;
  const auto is_apart = [&](std::span<const Vec2> other) {
    for (std::size_t i = 0; i < hole.size(); ++i)
      for (std::size_t k = 0; k < other.size(); ++k)
        if (do_segments_meet(hole[i], hole[(i + 1) % hole.size()], other[k], other[(k + 1) % other.size()]))
          return false;
    return true;
  };
  for (std::size_t h = 0; h < holes.size(); ++h)
    if (h != which && (!is_apart(holes[h]) || is_inside(holes[h], hole[0]))) return false;
  return is_apart(corners);
}

/// None if the polygon is not simple, or runs clockwise, or holes are none.
std::optional<FlatTriangulation> constrained_delaunay(std::span<const Vec2> corners,
                                                      std::span<const std::vector<Vec2>> holes) {
  if (!is_simple_polygon(corners) || doubled_area(corners) <= 0) return std::nullopt;
  for (std::size_t h = 0; h < holes.size(); ++h)
    if (!is_hole_of(corners, holes, h)) return std::nullopt;
  FlatTriangulation triangulation(corners, holes);
  triangulation.make_delaunay();
  return triangulation;
}

}  // namespace

bool is_inside(std::span<const Vec2> corners, const Vec2& point) {
  bool is_in = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (orient2d(a, b, point) * (b.y() > a.y() ? 1 : -1) > 0) is_in = !is_in;
  }
  return is_in;
}

bool is_simple_polygon(std::span<const Vec2> corners) {
  const std::size_t count = corners.size();
  if (count < 3) return false;
  const auto end = [&](std::size_t edge) -> const Vec2& { return corners[(edge + 1) % count]; };
  const auto low = [&](std::size_t edge) { return std::min(corners[edge].x(), end(edge).x()); };
  std::vector<std::size_t> order(count);  // By where edges begin along x.
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return low(a) < low(b); });
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t e = order[i];
    const double high = std::max(corners[e].x(), end(e).x());
    for (std::size_t k = i + 1; k < count && low(order[k]) <= high; ++k) {
      const std::size_t f = order[k];
      const bool is_next = f == (e + 1) % count, is_before = e == (f + 1) % count;
      if (is_next || is_before) {  // They share a corner, and overlap only where one turns back on the other.
        const Vec2 &a = is_next ? corners[e] : corners[f], &b = is_next ? end(e) : end(f),
                   &c = is_next ? end(f) : end(e);
        if (a == b || b == c || (orient2d(a, b, c) == 0 && (b - a).dot(c - b) < 0)) return false;
      } else if (do_segments_meet(corners[e], end(e), corners[f], end(f))) {
        return false;
      }
    }
  }
  return true;
}

std::optional<std::vector<Cell<3>>> triangulate_polygon(std::span<const Vec2> corners,
                                                        std::span<const std::vector<Vec2>> holes) {
  const auto triangulation = constrained_delaunay(corners, holes);
  if (!triangulation) return std::nullopt;
  return triangulation->triangles();
}

std::optional<PlanarPatch> fill_polygon(std::span<const Vec2> corners,
                                        std::span<const std::vector<Vec2>> holes) {
  constexpr int kPasses = 8;
  auto triangulation = constrained_delaunay(corners, holes);
  if (!triangulation) return std::nullopt;
  std::vector<double> sizes;
  append_sizes(corners, sizes);
  for (const std::vector<Vec2>& hole : holes) append_sizes(hole, sizes);
  Refinement(*triangulation, std::move(sizes)).run();
  for (int pass = 0; pass < kPasses; ++pass) {
    triangulation->smooth();
    triangulation->make_delaunay();
  }
  return PlanarPatch{triangulation->points(), triangulation->triangles()};
}

}  // namespace lumesh::surfaces
