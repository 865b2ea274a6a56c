#include "lumesh/surface/shells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::surfaces {

std::complex<double> half_view(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c,
                               const Vec3& eye) {
  const Vec3 a = corner_a - eye, b = corner_b - eye, c = corner_c - eye;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return {under, a.dot(b.cross(c)) + 0.0};  // No -0, whose argument would be -pi where 0 has +pi.
}

double share_of_view(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c, const Vec3& eye) {
  return std::arg(half_view(corner_a, corner_b, corner_c, eye)) / (2 * std::numbers::pi);
}

std::vector<Shell> shells_of(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                             const Parts& parts, const std::set<std::array<std::uint32_t, 2>>& crossing) {
  std::vector<Shell> shells(parts.count);
  for (std::size_t t = triangles.size(); t-- > 0;)
    shells[parts.of_triangle[t]].place_mm = points[triangles[t][0]];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Shell& shell = shells[parts.of_triangle[t]];
    const auto& [a, b, c] = triangles[t];
    shell.volume_mm3 += tetrahedron_volume(shell.place_mm, points[a], points[b], points[c]);
  }
  for (std::uint32_t s = 0; parts.count > 1 && s < parts.count; ++s) {
    const auto depth = parallel::sum<double>(triangles.size(), 4096, [&](std::size_t t) {
      const std::uint32_t other = parts.of_triangle[t];
      if (other == s || crossing.contains({std::min(s, other), std::max(s, other)})) return 0.0;
      const double share = share_of_view(points[triangles[t][0]], points[triangles[t][1]],
                                         points[triangles[t][2]], shells[s].place_mm);
      return share * (shells[other].volume_mm3 > 0 ? 1 : -1);
    });
    shells[s].depth = static_cast<int>(std::lround(depth));
  }
  return shells;
}

void turn_by_nesting(TriangleMesh& surface, std::span<const SelfCrossing> crossings) {
  const Parts parts = turn_alike(surface);
  std::set<std::array<std::uint32_t, 2>> crossing;
  for (const SelfCrossing& pair : crossings) {
    const auto [low, high] = std::minmax(parts.of_triangle[pair.first], parts.of_triangle[pair.second]);
    if (low != high) crossing.insert({low, high});
  }
  const std::vector<Shell> shells = shells_of(surface.points, surface.triangles, parts, crossing);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (shells[parts.of_triangle[t]].is_turned()) std::swap(surface.triangles[t][1], surface.triangles[t][2]);
}

}  // namespace lumesh::surfaces
