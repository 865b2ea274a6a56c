#include "plane_slide.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/plane_heights.hpp"

namespace lumesh::surfaces {
namespace {

bool keeps_its_side(const Vec3& before, const Vec3& after) {
  constexpr double kCosine = 0.7, kArea = 0.1;
  return before.dot(after) > kCosine * before.norm() * after.norm() && after.norm() > kArea * before.norm();
}

}  // namespace

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
  const Vec3 before = surface_.points[v];
  surface_.points[v] += *way;
  const double height = std::exchange(heights_[v], 0);
  bool is_good = true;
  for (std::size_t i = 0; i < normals.size() && is_good; ++i) {
    const std::uint32_t t = around_.of(v)[i];
    const Cell<3>& corners = surface_.triangles[t];
    const bool is_flat = std::ranges::all_of(corners, [&](std::uint32_t c) { return heights_[c] == 0; });
    is_good = !is_flat && keeps_its_side(normals[i], area_normal(t));
  }
  if (is_good) return true;
  surface_.points[v] = before;
  heights_[v] = height;
  return false;
}

}  // namespace lumesh::surfaces
