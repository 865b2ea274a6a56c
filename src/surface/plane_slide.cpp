#include "plane_slide.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/plane_heights.hpp"

namespace lumesh::surfaces {

double PlaneSlide::mean_edge_at(std::uint32_t v) const {
  double sum = 0;
  for (const std::uint32_t t : around_.of(v))
    for (const std::uint32_t w : surface_.triangles[t])
      sum += (surface_.points[w] - surface_.points[v]).norm();
  return sum / (2 * static_cast<double>(around_.of(v).size()));
}

Vec3 PlaneSlide::area_normal(std::uint32_t t) const {
  return triangle_area_normal(surface_.points, surface_.triangles[t]);
}

bool PlaneSlide::move(std::uint32_t v) {
  std::vector<Vec3> normals;
  Vec3 mean = Vec3::Zero();
  for (const std::uint32_t t : around_.of(v)) mean += normals.emplace_back(area_normal(t));
  mean.stableNormalize();
  const std::optional<Vec3> way = way_into_plane(heights_[v], normal_, mean);
  if (!way) return false;
  return slide_point(v, *way, surface_.points, heights_, [&] {
    constexpr double kArea = 0.1;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const std::uint32_t t = around_.of(v)[i];
      const Vec3 normal = area_normal(t);
      if (std::ranges::all_of(surface_.triangles[t], [&](std::uint32_t c) { return heights_[c] == 0; }) ||
          !turns_little(normals[i], normal) || normal.norm() <= kArea * normals[i].norm())
        return false;
    }
    return true;
  });
}

}  // namespace lumesh::surfaces
