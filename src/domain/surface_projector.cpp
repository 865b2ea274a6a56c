#include "surface_projector.hpp"

#include <Eigen/Geometry>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh::surfaces {
namespace {

/// The part of a triangle that is nearest to a place: a corner, the edge from a corner to the next, or its
/// inside.
struct NearestPart {
  enum class Kind : std::uint8_t { kCorner, kEdge, kInside } kind;
  std::size_t index;
};

/// Decides as closest_point_on_triangle(), so that both agree to the last bit.
NearestPart nearest_part(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  using enum NearestPart::Kind;
  const auto on_segment = [&](const Vec3& from, const Vec3& to, std::size_t edge, std::size_t start,
                              std::size_t end) {
    const Vec3 x = closest_point_on_segment(p, from, to);
    return x == from ? NearestPart{kCorner, start}
           : x == to ? NearestPart{kCorner, end}
                     : NearestPart{kEdge, edge};
  };
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {kCorner, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {kCorner, 1};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {kCorner, 2};
  if (d1 * d4 - d3 * d2 <= 0 && d1 >= 0 && d3 <= 0) return on_segment(a, b, 0, 0, 1);
  if (d5 * d2 - d1 * d6 <= 0 && d2 >= 0 && d6 <= 0) return on_segment(a, c, 2, 0, 2);
  if (d3 * d6 - d5 * d4 <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return on_segment(b, c, 1, 1, 2);
  return {kInside, 0};
}

NearestPart part_at_closest(const ClosedSurface& surface, const Vec3& x, const ClosestPoint& closest) {
  return nearest_part(x, surface.corner(closest.triangle, 0), surface.corner(closest.triangle, 1),
                      surface.corner(closest.triangle, 2));
}

double angle_at(const ClosedSurface& surface, std::uint32_t t, std::size_t i) {
  const Vec3 u = surface.corner(t, (i + 1) % 3) - surface.corner(t, i);
  const Vec3 v = surface.corner(t, (i + 2) % 3) - surface.corner(t, i);
  return angle_between(u, v);
}

/// Calls visit(triangle) for all triangles around a corner of one.
template <class Visit>
void for_each_around(const ClosedSurface& surface, std::uint32_t triangle, std::size_t corner,
                     const Visit& visit) {
  const std::uint32_t v = surface.triangles[triangle][corner];
  std::uint32_t t = triangle;
  std::size_t i = corner;
  do {
    visit(t);
    t = surface.neighbours[t][i];
    for (i = 0; surface.triangles[t][i] != v;) ++i;
  } while (t != triangle);
}

}  // namespace

SurfaceProjector::SurfaceProjector(const ClosedSurface& surface, const FeatureRegions& regions)
    : surface_(surface), regions_(regions), tree_(surface.points, surface.triangles) {
  find_point_normals();
  if (regions.count() > 1) plant_region_trees();
}

void SurfaceProjector::find_point_normals() {
  point_normals_.assign(surface_.points.size(), Vec3::Zero());
  for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      point_normals_[surface_.triangles[t][i]] += angle_at(surface_, t, i) * surface_.normals[t];
}

void SurfaceProjector::plant_region_trees() {
  std::vector<std::vector<std::uint32_t>> members(regions_.count());
  for (std::uint32_t t = 0; t < regions_.of_triangle.size(); ++t)
    members[regions_.of_triangle[t]].push_back(t);
  for (std::vector<std::uint32_t>& triangles : members) {
    std::vector<Cell<3>> cells;
    Box3 box;
    for (const std::uint32_t t : triangles) {
      cells.push_back(surface_.triangles[t]);
      for (const std::uint32_t v : surface_.triangles[t]) box.extend(surface_.points[v]);
    }
    region_trees_.push_back({TriangleTree(surface_.points, cells), std::move(triangles), box});
  }
}

ClosestPoint SurfaceProjector::closest_on(const Vec3& x, std::uint32_t triangle) const {
  const Vec3 point = closest_point_on_triangle(x, surface_.corner(triangle, 0), surface_.corner(triangle, 1),
                                               surface_.corner(triangle, 2));
  return {(point - x).norm(), point, triangle};
}

ClosestPoint SurfaceProjector::nearest(const Vec3& x, std::uint32_t guess) const {
  const ClosestPoint guessed = closest_on(x, guess);
  const TriangleTree::Nearest found = tree_.nearest(x, guessed.distance);
  // The search is bounded by the guess's own distance; rounding may exclude the guess.
  return found.triangle == TriangleTree::kNone ? guessed : closest_of(found);
}

ClosestPoint SurfaceProjector::nearly_nearest(const Vec3& x, std::uint32_t guess,
                                              double relative_slack) const {
  const ClosestPoint guessed = closest_on(x, guess);
  const TriangleTree::Nearest found =
      tree_.nearest(x, (1 - relative_slack) * guessed.distance, relative_slack);
  return found.triangle == TriangleTree::kNone ? guessed : closest_of(found);
}

ClosestPoint SurfaceProjector::nearest_of_region(const Vec3& x, std::uint32_t region, double reach) const {
  if (region_trees_.empty()) return closest_of(tree_.nearest(x, reach));
  const RegionTree& one = region_trees_[region];
  if (one.box.squaredExteriorDistance(x) > reach * reach) return {};
  ClosestPoint closest = closest_of(one.tree.nearest(x, reach));
  if (closest.triangle != TriangleTree::kNone) closest.triangle = one.triangles[closest.triangle];
  return closest;
}

bool SurfaceProjector::is_inside(const Vec3& x, const ClosestPoint& closest) const {
  const NearestPart part = part_at_closest(surface_, x, closest);
  Vec3 normal = surface_.normals[closest.triangle];
  if (part.kind == NearestPart::Kind::kCorner)
    normal = point_normals_[surface_.triangles[closest.triangle][part.index]];
  else if (part.kind == NearestPart::Kind::kEdge)
    normal += surface_.normals[surface_.neighbours[closest.triangle][part.index]];
  return normal.dot(x - closest.point) < 0;
}

std::uint32_t SurfaceProjector::region_over(const Vec3& x, const ClosestPoint& closest) const {
  std::uint32_t best = closest.triangle;
  const NearestPart part = part_at_closest(surface_, x, closest);
  const Vec3 up = x - closest.point;
  const auto consider = [&](std::uint32_t t) {
    // The lower region where they are equal, whichever triangle was found first.
    const double height = up.dot(surface_.normals[t]), most = up.dot(surface_.normals[best]);
    if (height > most || (height == most && regions_.of_triangle[t] < regions_.of_triangle[best])) best = t;
  };
  if (part.kind == NearestPart::Kind::kEdge) consider(surface_.neighbours[closest.triangle][part.index]);
  if (part.kind == NearestPart::Kind::kCorner)
    for_each_around(surface_, closest.triangle, part.index, consider);
  return regions_.of_triangle[best];
}

}  // namespace lumesh::surfaces
