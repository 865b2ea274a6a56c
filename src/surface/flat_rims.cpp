#include "flat_rims.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/planar_patch.hpp"
#include "rim_triangles.hpp"

namespace lumesh::surfaces {
namespace {

/// The nearest point in all planes; none where they hardly meet in one.
std::optional<Vec3> nearest_in(const std::vector<Plane>& planes, const Vec3& point) {
  Eigen::MatrixX3d normals(planes.size(), 3);
  Eigen::VectorXd heights(planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    normals.row(row) = planes[i].second.transpose();
    heights[row] = planes[i].second.dot(planes[i].first - point);
  }
  constexpr double kMinSine = 0.1;  // Between planes.
  Eigen::JacobiSVD<Eigen::MatrixXd> solver(normals, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (planes.size() > 3 || solver.singularValues().tail<1>()[0] < kMinSine) return std::nullopt;
  return Vec3(point + solver.solve(heights));
}

/// Where a rim shares a vertex with one before it, almost in its plane: that plane.
Plane plane_of(const Rim& rim, const VertexPlanes& planes) {
  constexpr double kParallel = 0.99;
  for (const std::uint32_t v : rim.vertices) {
    const auto found = planes.find(v);
    if (found == planes.end()) continue;
    for (const Plane& plane : found->second)
      if (std::abs(plane.second.dot(rim.normal)) > kParallel) return plane;
  }
  return {rim.centre_mm, rim.normal};
}

Vec3 normal_at(const TriangleMesh& surface, std::size_t t) {
  return triangle_area_normal(surface.points, surface.triangles[t]);
}

}  // namespace

PlaneFrame::PlaneFrame(const Rim& rim)
    : origin(rim.centre_mm), u(rim.normal.unitOrthogonal()), v(rim.normal.cross(u)) {}

std::vector<Vec2> PlaneFrame::polygon(const Rim& rim, const std::vector<Vec3>& points) const {
  std::vector<Vec2> corners;
  for (std::size_t i = rim.vertices.size(); i-- > 0;) corners.push_back(flat(points[rim.vertices[i]]));
  return corners;
}

std::vector<std::vector<std::uint32_t>> rim_triangles(const TriangleMesh& surface,
                                                      std::span<const Rim> rims) {
  struct RimEdge {
    std::uint32_t from, to;
    std::size_t rim, place;
    auto operator<=>(const RimEdge&) const = default;
  };
  std::vector<RimEdge> edges;
  std::vector<std::vector<std::uint32_t>> triangles;
  for (std::size_t r = 0; r < rims.size(); ++r) {
    const std::vector<std::uint32_t>& vertices = rims[r].vertices;
    triangles.emplace_back(vertices.size(), 0);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      edges.push_back({vertices[i], vertices[(i + 1) % vertices.size()], r, i});
  }
  std::ranges::sort(edges);
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t from = surface.triangles[t][s], to = surface.triangles[t][(s + 1) % 3];
      const auto at = std::ranges::lower_bound(edges, RimEdge{from, to, 0, 0});
      if (at != edges.end() && at->from == from && at->to == to) triangles[at->rim][at->place] = t;
    }
  return triangles;
}

double cosine_to_wall(const TriangleMesh& surface, const Rim& rim, std::span<const std::uint32_t> triangles) {
  double length = 0, cosine = 0;
  for (std::size_t i = 0; i < rim.vertices.size(); ++i) {
    const Vec3 &from = surface.points[rim.vertices[i]],
               &to = surface.points[rim.vertices[(i + 1) % rim.vertices.size()]];
    const double edge = (to - from).norm();
    length += edge;
    cosine += edge * std::abs(rim.normal.dot(normal_at(surface, triangles[i]).stableNormalized()));
  }
  return cosine / length;
}

std::int32_t commonest_patch(const TriangleMesh& surface, std::span<const std::uint32_t> triangles) {
  std::map<std::int32_t, std::size_t> counts;
  for (const std::uint32_t t : triangles) ++counts[surface.patches[t]];
  return std::ranges::max_element(counts, [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

bool leaves_plane_at_angle(const TriangleMesh& surface, const Rim& rim, double min_angle_deg) {
  const double max_cosine = cosine_deg(min_angle_deg);
  const std::vector<std::uint32_t> triangles = rim_triangles(surface, {&rim, 1}).front();
  return std::ranges::none_of(triangles, [&](std::uint32_t t) {
    // Under the cap, the surface faces the other way.
    return normal_at(surface, t).stableNormalized().dot(rim.normal) < -max_cosine;
  });
}

std::optional<FlatRim> move_into_plane(TriangleMesh& surface, const Rim& rim, VertexPlanes& planes,
                                       double min_angle_deg, const std::optional<Plane>& wanted) {
  const Plane plane = wanted ? *wanted : plane_of(rim, planes);
  FlatRim flat{rim};
  flat.rim.centre_mm -= plane.second.dot(rim.centre_mm - plane.first) * plane.second;
  flat.rim.normal = plane.second.dot(rim.normal) < 0 ? Vec3(-plane.second) : plane.second;
  TriangleMesh moved = surface;
  VertexPlanes constrained = planes;
  for (const std::uint32_t v : rim.vertices) {
    std::vector<Plane>& mine = constrained[v];
    if (std::ranges::find(mine, plane) == mine.end()) mine.push_back(plane);
    const std::optional<Vec3> place = nearest_in(mine, surface.points[v]);
    if (!place) return std::nullopt;
    flat.moved_mm = std::max(flat.moved_mm, (*place - surface.points[v]).norm());
    moved.points[v] = *place;
  }
  if (flat.moved_mm > Rim::kMaxBent * rim.radius_mm + rim.mean_edge_mm) return std::nullopt;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Cell<3>& corners = surface.triangles[t];
    const bool is_moved =
        std::ranges::any_of(corners, [&](std::uint32_t v) { return moved.points[v] != surface.points[v]; });
    if (is_moved && !(normal_at(moved, t).dot(normal_at(surface, t)) > 0)) return std::nullopt;
  }
  if (!leaves_plane_at_angle(moved, flat.rim, min_angle_deg)) return std::nullopt;
  if (!is_simple_polygon(PlaneFrame(flat.rim).polygon(rim, moved.points))) return std::nullopt;
  surface.points = std::move(moved.points);
  planes = std::move(constrained);
  return flat;
}

}  // namespace lumesh::surfaces
