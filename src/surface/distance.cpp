#include "lumesh/surface/distance.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::surfaces {
namespace {

FarthestPoint farther(const FarthestPoint& a, const FarthestPoint& b) {
  return b.distance_mm > a.distance_mm ? b : a;
}

/// A point and what of another surface is nearest to it.
struct Measured {
  Vec3 point = Vec3::Zero();
  TriangleTree::Nearest nearest;
};
using MeasuredCorners = std::array<Measured, 3>;

double longest_edge(const MeasuredCorners& c) {
  return std::max(
      {(c[1].point - c[0].point).norm(), (c[2].point - c[1].point).norm(), (c[0].point - c[2].point).norm()});
}

/// The farthest point of one triangle after another.
template <class LeftOutWithin>
class FarthestSearch {
 public:
  /// @param farthest  Of the triangles before.
  FarthestSearch(const TriangleTree& other, FarthestPoint& farthest, const LeftOutWithin& left_out_within)
      : other_(other), farthest_(farthest), left_out_within_(left_out_within) {}

  void look_at(const Measured& place) {
    if (place.nearest.distance <= farthest_.distance_mm || is_left_out(place)) return;
    const double radius = left_out_within_(place.point);
    if (radius < 0)
      farthest_ = {place.nearest.distance, place.point};
    else
      left_out_ = {place.point, radius};
  }
  /// Looks at middles of edges and centres of n^2 equal parts, n a power of two, wherever a point may be
  /// farther than those before.
  void look_within(const MeasuredCorners& corners, double longest, unsigned n) {
    if (!may_hold_farther(corners, longest)) return;
    // A ball is convex.
    if (is_left_out(corners[0]) && is_left_out(corners[1]) && is_left_out(corners[2])) return;
    if (n == 1)
      return look_at(measured((corners[0].point + corners[1].point + corners[2].point) / 3, corners[0]));
    MeasuredCorners middles;  // Each behind the corner of its number.
    for (std::size_t i = 0; i < 3; ++i) {
      const Measured &from = corners[(i + 1) % 3], &to = corners[(i + 2) % 3];
      middles[i] = measured((from.point + to.point) / 2, from);
      look_at(middles[i]);
    }
    look_within(middles, longest / 2, n / 2);
    for (std::size_t i = 0; i < 3; ++i)
      look_within({corners[i], middles[(i + 2) % 3], middles[(i + 1) % 3]}, longest / 2, n / 2);
  }

 private:
  /// Points of the triangle that do not count.
  struct LeftOut {
    Vec3 middle = Vec3::Zero();
    double radius = 0;
  };
  [[nodiscard]] bool is_left_out(const Measured& place) const {
    return (place.point - left_out_.middle).squaredNorm() < left_out_.radius * left_out_.radius;
  }
  /// Distances to one triangle are convex: none within is larger than the largest at the corners. In general
  /// they grow no faster than the way, and no point is farther from all corners than the longest edge by the
  /// root of three.
  [[nodiscard]] bool may_hold_farther(const MeasuredCorners& corners, double longest) const {
    const auto& [a, b, c] = corners;
    const bool is_along_one =
        a.nearest.triangle == b.nearest.triangle && b.nearest.triangle == c.nearest.triangle;
    const double most = std::max({a.nearest.distance, b.nearest.distance, c.nearest.distance}) +
                        (is_along_one ? 0 : longest * std::numbers::inv_sqrt3);
    return most > farthest_.distance_mm;
  }
  [[nodiscard]] Measured measured(const Vec3& point, const Measured& beside) const {
    constexpr double kRounding = 1 + 1e-9;
    const double most_mm = kRounding * (beside.nearest.distance + (point - beside.point).norm());
    const TriangleTree::Nearest near = other_.nearest(point, most_mm);
    return {point, near.triangle != TriangleTree::kNone ? near : other_.nearest(point)};
  }

  const TriangleTree& other_;
  FarthestPoint& farthest_;
  const LeftOutWithin& left_out_within_;
  LeftOut left_out_;  // The last that were found.
};

}  // namespace

FarthestPoint farthest_from(const TriangleMesh& surface, const TriangleTree& other, double step_mm,
                            const std::function<bool(std::size_t)>& is_wanted,
                            const std::function<double(const Vec3&, std::size_t)>& left_out_within) {
  constexpr std::size_t kBlock = 64;
  const std::size_t count = surface.triangles.size();
  std::vector<std::uint8_t> is_corner(surface.points.size(), 0);
  for (std::size_t t = 0; t < count; ++t)
    if (!is_wanted || is_wanted(t))
      for (const std::uint32_t v : surface.triangles[t]) is_corner[v] = 1;
  std::vector<Measured> measured(surface.points.size());
  parallel::for_each_index(measured.size(), [&](std::size_t v) {
    if (is_corner[v] != 0) measured[v] = {surface.points[v], other.nearest(surface.points[v])};
  });
  const auto search = [&](const FarthestPoint& start, const auto& look) {
    return parallel::reduce(
        count, kBlock, start,
        [&](FarthestPoint& farthest, std::size_t t) {
          if (is_wanted && !is_wanted(t)) return;
          const auto& [a, b, c] = surface.triangles[t];
          const auto within = [&](const Vec3& p) { return left_out_within ? left_out_within(p, t) : -1.0; };
          look(FarthestSearch(other, farthest, within),
               MeasuredCorners{measured[a], measured[b], measured[c]});
        },
        farther);
  };
  // Corners first: what the farthest of them leaves out need not be looked into.
  const FarthestPoint of_corners = search({}, [](auto finder, const MeasuredCorners& corners) {
    for (const Measured& corner : corners) finder.look_at(corner);
  });
  return search(of_corners, [&](auto finder, const MeasuredCorners& corners) {
    constexpr double kMaxParts = 64;
    const double longest = longest_edge(corners);
    finder.look_within(
        corners, longest,
        std::bit_ceil(static_cast<unsigned>(std::clamp(std::ceil(longest / step_mm), 1.0, kMaxParts))));
  });
}

}  // namespace lumesh::surfaces
