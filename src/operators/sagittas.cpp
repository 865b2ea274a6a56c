#include "lumesh/operators/sagittas.hpp"

#include "lumesh/geometry/triangle.hpp"

namespace lumesh::operators {

double arc_height(const SurfacePoint& from, const SurfacePoint& to) {
  return (to.normal - from.normal).dot(to.point - from.point) / 8;
}

std::optional<double> mean_height_over(const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& over,
                                       const PlaceNear& place) {
  std::array<Vec3, 3> over_middles;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto found = place(0.5 * (corners[k] + corners[(k + 1) % 3]));
    if (!found) return std::nullopt;
    over_middles[k] = found->point;
  }
  // Six times what lies between the triangle and that of the places over its corners, and between it and the
  // four of all places. The sides cancel with those of the neighbours.
  const auto under = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    return (p - corners[0]).cross(q - corners[0]).dot(r - corners[0]);
  };
  double flat = under(over[0], over[1], over[2]),
         bent = under(over_middles[0], over_middles[1], over_middles[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3, before = (k + 2) % 3;
    const Vec3 &a = corners[k], &b = corners[next], &over_a = over[k], &over_b = over[next],
               &middle = over_middles[k];
    flat += 0.5 *
            (under(a, b, over_b) + under(a, over_b, over_a) + under(a, b, over_a) + under(b, over_b, over_a));
    bent += under(a, b, middle) + under(b, over_b, middle) + under(a, middle, over_a) +
            under(over_a, middle, over_middles[before]);
  }
  const double area = triangle_area(corners[0], corners[1], corners[2]);
  // What flat triangles miss is quartered where their edges are halved.
  return area > 0 ? (bent + (bent - flat) / 3) / (6 * area) : 0;
}

double mean_arc_height(const SurfacePoint& from, const SurfacePoint& to) {
  return 2 * arc_height(from, to) / 3;  // A parabola's.
}

double sagitta_of(const std::array<SurfacePoint, 3>& corners) {
  // By the rule of the edges' middles.
  const auto& [a, b, c] = corners;
  return (arc_height(a, b) + arc_height(b, c) + arc_height(c, a)) / 3;
}

}  // namespace lumesh::operators
