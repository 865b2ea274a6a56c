#include "lumesh/mesh/triangle_sides.hpp"

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {

std::vector<TriangleSide> sorted_sides(std::span<const Cell<3>> triangles) {
  std::vector<TriangleSide> sides(3 * triangles.size());
  parallel::for_each_index(triangles.size(), [&](std::size_t t) {
    for (std::uint32_t s = 0; s < 3; ++s) sides[3 * t + s] = side_of(triangles[t], t, s);
  });
  parallel::sort(sides.begin(), sides.end());
  return sides;
}

DisjointSets smooth_parts(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                          std::span<const std::int32_t> patches, double feature_angle_deg) {
  DisjointSets parts(triangles.size());
  const double min_cosine = cosine_deg(feature_angle_deg);
  const auto turns_little = [&](std::uint32_t s, std::uint32_t t) {
    const Vec3 n = triangle_area_normal(points, triangles[s]), m = triangle_area_normal(points, triangles[t]);
    return n.dot(m) >= min_cosine * n.norm() * m.norm();
  };
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> edge) {
    for (std::size_t i = 0; i < edge.size(); ++i)
      for (std::size_t j = i + 1; j < edge.size(); ++j)
        if (const std::uint32_t s = edge[i].triangle, t = edge[j].triangle;
            patches[s] >= 0 && patches[s] == patches[t] && turns_little(s, t))
          parts.merge(s, t);
  });
  return parts;
}

}  // namespace lumesh
