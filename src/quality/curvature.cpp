#include "lumesh/quality/curvature.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {

namespace {

/// A triangle as one of its vertices sees it.
struct Corner {
  std::uint32_t vertex;
  std::uint32_t next;  ///< The other two in the order of the triangle.
  std::uint32_t last;
  std::uint32_t opening;  ///< 1 if the triangle belongs to one.
  auto operator<=>(const Corner&) const = default;
};

parallel::KeyTable<Corner> outer_corners(const MeshView& mesh, const MeshSurface& surface) {
  const std::vector<Patch>& patches = mesh.info->patches;
  std::vector<Corner> corners;
  corners.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (surface.labels[t][1] != kOutside) continue;
    const std::int32_t patch = surface.patches[t];
    const bool known = patch >= 0 && static_cast<std::size_t>(patch) < patches.size();
    const bool opening = known && is_plane(patches[static_cast<std::size_t>(patch)].kind);
    const auto& [a, b, c] = surface.triangles[t];
    for (const auto& [v, next, last] : {Cell<3>{a, b, c}, Cell<3>{b, c, a}, Cell<3>{c, a, b}})
      corners.push_back({v, next, last, opening ? 1U : 0U});
  }
  return {corners, mesh.points.size(), [](const Corner& corner) { return corner.vertex; }};
}

/// True if the triangles go all the way round and none belongs to an opening.
bool is_inside_wall(std::span<const Corner> corners) {
  std::vector<std::uint32_t> neighbours;
  for (const Corner& corner : corners) {
    if (corner.opening != 0) return false;
    neighbours.insert(neighbours.end(), {corner.next, corner.last});
  }
  std::ranges::sort(neighbours);
  bool all_twice = !neighbours.empty();
  parallel::for_each_run(neighbours, std::equal_to<>(), [&](std::span<const std::uint32_t> run) {
    all_twice = all_twice && run.size() == 2;
  });
  return all_twice;
}

/// Cotangent of the angle at `apex`; large, but finite for an angle of 0.
double cotangent(const Vec3& apex, const Vec3& a, const Vec3& b) {
  const Vec3 u = a - apex, v = b - apex;
  return u.dot(v) / std::max(u.cross(v).norm(), std::numeric_limits<double>::min());
}

struct AtVertex {
  Vec3 sum = Vec3::Zero();     // Over the edges: cotangents times the way from the neighbour.
  Vec3 normal = Vec3::Zero();  // Sum of area normals.
  double area = 0;
};

/// Adds what one triangle gives. Source: Meyer et al. 2003, equation 8 and figure 4.
void add_corner(const Vec3& p, const Vec3& q, const Vec3& r, AtVertex& at) {
  const double at_p = cotangent(p, q, r), at_q = cotangent(q, r, p), at_r = cotangent(r, p, q);
  const Vec3 area_normal = triangle_area_normal(p, q, r);
  const double area = area_normal.norm() / 2;
  at.sum += at_r * (p - q) + at_q * (p - r);
  at.normal += area_normal;
  if (at_p < 0)
    at.area += area / 2;
  else if (at_q < 0 || at_r < 0)
    at.area += area / 4;
  else
    at.area += ((p - q).squaredNorm() * at_r + (p - r).squaredNorm() * at_q) / 8;
}

/// The value below which a share of the weight lies; `items` are values and weights, sorted.
double percentile(const std::vector<std::pair<double, double>>& items, double weight, double share) {
  double below = 0;
  for (const auto& [value, part] : items) {
    below += part;
    if (below >= share * weight) return value;
  }
  return items.empty() ? 0 : items.back().first;
}

}  // namespace

WallCurvature wall_curvature(const MeshView& mesh, const MeshSurface& surface) {
  const parallel::KeyTable<Corner> corners = outer_corners(mesh, surface);
  WallCurvature result;
  result.mean_per_mm.assign(mesh.points.size(), std::numeric_limits<double>::quiet_NaN());
  result.area_mm2.assign(mesh.points.size(), 0);
  parallel::for_each_index(mesh.points.size(), [&](std::size_t v) {
    if (!is_inside_wall(corners.of(v))) return;
    AtVertex at;
    for (const Corner& corner : corners.of(v))
      add_corner(mesh.points[v], mesh.points[corner.next], mesh.points[corner.last], at);
    const double size = at.sum.norm() / (4 * at.area);  // Half of equation 8's vector.
    if (!(at.area > 0) || !std::isfinite(size)) return;
    result.mean_per_mm[v] = at.sum.dot(at.normal) < 0 ? -size : size;
    result.area_mm2[v] = at.area;
  });
  return result;
}

CurvatureSummary summarise(const WallCurvature& curvature) {
  std::vector<std::pair<double, double>> items;
  double area = 0, sum = 0, squares = 0;
  for (std::size_t v = 0; v < curvature.area_mm2.size(); ++v) {
    const double part = curvature.area_mm2[v], value = curvature.mean_per_mm[v];
    if (!(part > 0)) continue;
    items.emplace_back(value, part);
    area += part;
    sum += part * value;
    squares += part * value * value;
  }
  CurvatureSummary result;
  if (items.empty()) return result;
  parallel::sort(items.begin(), items.end());
  result.vertices = items.size();
  result.mean_per_mm = sum / area;
  result.root_mean_square_per_mm = std::sqrt(squares / area);
  result.p2_per_mm = percentile(items, area, 0.02);
  result.p98_per_mm = percentile(items, area, 0.98);
  return result;
}

}  // namespace lumesh::quality
