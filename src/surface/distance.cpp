#include "lumesh/surface/distance.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/parallel/sum.hpp"

namespace lumesh::surfaces {
namespace {

FarthestPoint farther(const FarthestPoint& a, const FarthestPoint& b) {
  return b.distance_mm > a.distance_mm ? b : a;
}

using CountsPoint = std::function<bool(const Vec3&)>;

/// @param farthest  Of the triangles before.
FarthestPoint farthest_of_triangle(const std::array<Vec3, 3>& corners, const TriangleTree& other,
                                   double step_mm, FarthestPoint farthest, const CountsPoint& counts) {
  constexpr double kMaxParts = 64;
  const auto look_at = [&](const Vec3& p) {
    const double distance = other.nearest(p).distance;
    if (distance > farthest.distance_mm && counts(p)) farthest = {distance, p};
  };
  for (const Vec3& corner : corners) look_at(corner);
  const Vec3 u = corners[1] - corners[0], v = corners[2] - corners[0];
  const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
  const int parts = static_cast<int>(std::clamp(std::ceil(longest / step_mm), 1.0, kMaxParts));
  for_each_part_centre(corners[0], corners[1], corners[2], parts, look_at);
  return farthest;
}

}  // namespace

FarthestPoint farthest_from(const TriangleMesh& surface, const TriangleTree& other, double step_mm,
                            const std::function<bool(std::size_t)>& is_wanted,
                            const std::function<bool(const Vec3&, std::size_t)>& counts) {
  constexpr std::size_t kBlock = 64;
  return parallel::reduce(
      surface.triangles.size(), kBlock, FarthestPoint(),
      [&](FarthestPoint& farthest, std::size_t t) {
        if (is_wanted && !is_wanted(t)) return;
        const Cell<3>& c = surface.triangles[t];
        farthest =
            farthest_of_triangle({surface.points[c[0]], surface.points[c[1]], surface.points[c[2]]}, other,
                                 step_mm, farthest, [&](const Vec3& p) { return !counts || counts(p, t); });
      },
      farther);
}

}  // namespace lumesh::surfaces
