#include "surface_parts.hpp"

#include <algorithm>
#include <functional>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/repair.hpp"

namespace lumesh::surfaces {
namespace {

// Of the largest part's area: an open part that lies on others, whichever way it is turned.
constexpr double kFlapArea = 0.05;

}  // namespace

MarkedTriangles fins(const TriangleMesh& surface) {
  const std::size_t count = surface.triangles.size();
  std::vector<std::uint8_t> crowded(count, 0), open(count, 0);
  for_each_edge(sorted_sides(surface.triangles), [&](std::span<const TriangleSide> edge) {
    if (edge.size() == 1) ++open[edge[0].triangle];
    if (edge.size() > 2)
      for (const TriangleSide& side : edge) ++crowded[side.triangle];
  });
  MarkedTriangles marked{std::vector<std::uint8_t>(count, 0)};
  for (std::size_t t = 0; t < count; ++t)
    if (crowded[t] == 1 && open[t] == 2) {
      marked.is_marked[t] = 1;
      ++marked.count;
    }
  return marked;
}

SurfaceParts::SurfaceParts(TriangleMesh& surface)
    : surface_(surface), triangle_count_(surface.triangles.size()) {
  const EdgeNeighbours neighbours = edge_neighbours(surface.triangles);
  const Parts parts = turn_alike(surface.triangles, neighbours);
  parts_.resize(parts.count);
  for (std::uint32_t t = 0; t < triangle_count_; ++t) {
    Part& part = parts_[parts.of_triangle[t]];
    part.area_mm2 += triangle_area(surface.points, surface.triangles[t]);
    for (const std::uint32_t v : surface.triangles[t]) part.box.extend(surface.points[v]);
    part.triangles.push_back(t);
    for (const std::uint32_t n : neighbours[t]) part.is_open = part.is_open || n >= kCrowdedEdge;
  }
}

MarkedTriangles SurfaceParts::specks_and_copies(double speck_mm, double distance_mm) const {
  MarkedTriangles marked = none();
  if (parts_.size() < 2) return marked;
  std::vector<std::reference_wrapper<const Part>> by_area(parts_.begin(), parts_.end());
  std::ranges::stable_sort(by_area, [](const Part& a, const Part& b) { return a.area_mm2 > b.area_mm2; });
  std::vector<Cell<3>> kept;
  const auto keep = [&](const Part& part) {
    for (const std::uint32_t t : part.triangles) kept.push_back(surface_.triangles[t]);
    return TriangleTree(surface_.points, kept);
  };
  const Part& largest = by_area.front();
  TriangleTree tree = keep(largest);
  for (const Part& part : std::span(by_area).subspan(1)) {
    const bool is_flap = part.is_open && part.area_mm2 < kFlapArea * largest.area_mm2;
    if (part.box.diagonal().norm() < speck_mm || lies_on(part, tree, kept, distance_mm, is_flap))
      mark(part, marked);
    else
      tree = keep(part);
  }
  return marked;
}

/// Whether a part lies along others and, unless the way it is turned does not matter, is turned as they are.
bool SurfaceParts::lies_on(const Part& part, const TriangleTree& tree, const std::vector<Cell<3>>& others,
                           double distance_mm, bool either_way) const {
  double alike = 0;
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t t : part.triangles)
    corners.insert(corners.end(), surface_.triangles[t].begin(), surface_.triangles[t].end());
  sort_unique(corners);
  const auto nearest = [&](const Vec3& point) { return tree.nearest(point, distance_mm).triangle; };
  for (const std::uint32_t v : corners)
    if (nearest(surface_.points[v]) == TriangleTree::kNone) return false;
  for (const std::uint32_t t : part.triangles) {
    const std::uint32_t beside = nearest(middle_of(t));
    if (beside == TriangleTree::kNone) return false;
    alike += triangle_area_normal(surface_.points, surface_.triangles[t])
                 .dot(triangle_normal(surface_.points, others[beside]));
  }
  return either_way || alike > 0;
}

MarkedTriangles SurfaceParts::hanging() const {
  MarkedTriangles marked = none();
  if (parts_.size() < 2) return marked;
  std::vector<double> largest_at(surface_.points.size(), 0);
  const auto for_each_corner = [&](const Part& part, const auto& visit) {
    for (const std::uint32_t t : part.triangles)
      for (const std::uint32_t v : surface_.triangles[t]) visit(v);
  };
  for (const Part& part : parts_)
    for_each_corner(part, [&](std::uint32_t v) { largest_at[v] = std::max(largest_at[v], part.area_mm2); });
  for (const Part& part : parts_) {
    bool hangs = false;
    for_each_corner(part, [&](std::uint32_t v) {
      hangs = hangs || (part.is_open && part.area_mm2 < kFlapArea * largest_at[v]);
    });
    if (hangs) mark(part, marked);
  }
  return marked;
}

MarkedTriangles SurfaceParts::islands(const std::vector<std::uint32_t>& opening_of) const {
  MarkedTriangles marked = none();
  double largest = 0;
  for (const Part& part : parts_) largest = std::max(largest, part.area_mm2);
  const auto is_at_opening = [&](std::uint32_t t) {
    return std::ranges::any_of(surface_.triangles[t],
                               [&](std::uint32_t v) { return v < opening_of.size() && opening_of[v] != 0; });
  };
  for (const Part& part : parts_)
    if (part.is_open && part.area_mm2 < kFlapArea * largest &&
        std::ranges::none_of(part.triangles, is_at_opening))
      mark(part, marked);
  return marked;
}

void SurfaceParts::mark(const Part& part, MarkedTriangles& marked) const {
  for (const std::uint32_t t : part.triangles) marked.is_marked[t] = 1;
  marked.count += part.triangles.size();
  ++marked.parts;
  if (part.triangles.size() <= marked.largest) return;
  marked.largest = part.triangles.size();
  marked.largest_mm = middle_of(part.triangles.front());
}

Vec3 SurfaceParts::middle_of(std::uint32_t t) const {
  return triangle_centre(surface_.points, surface_.triangles[t]);
}

std::uint64_t drop_specks_and_copies(TriangleMesh& surface, double distance_mm) {
  const double speck_mm = kSpeckShare * bounding_box(surface.points).diagonal().norm();
  const MarkedTriangles marked = SurfaceParts(surface).specks_and_copies(speck_mm, distance_mm);
  drop_triangles(surface, marked.is_marked);
  return marked.parts;
}

}  // namespace lumesh::surfaces
