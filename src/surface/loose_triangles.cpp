#include "lumesh/surface/loose_triangles.hpp"

#include <algorithm>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {
namespace {

/// Triangles that are connected over edges so that the graph of their neighbours is a tree make a disc all of
/// whose vertices lie on its rim: each but the first adds one vertex.
bool is_disc_without_inner_vertex(const TriangleMesh& surface, const std::vector<std::uint32_t>& part) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t t : part)
    vertices.insert(vertices.end(), surface.triangles[t].begin(), surface.triangles[t].end());
  sort_unique(vertices);
  return vertices.size() == part.size() + 2;
}

}  // namespace

std::vector<std::uint32_t> loose_triangles(const TriangleMesh& surface) {
  constexpr std::size_t kMax = 20;
  constexpr double kMaxShare = 1e-3;
  const EdgeNeighbours neighbours = edge_neighbours(surface.triangles);
  std::vector<Cell<3>> alike = surface.triangles;
  const Parts parts = turn_alike(alike, neighbours);
  if (parts.count < 2) return {};
  std::vector<std::vector<std::uint32_t>> members(parts.count);
  std::vector<double> areas(parts.count, 0);
  std::vector<bool> is_at_others(parts.count, false);  // Over edges of three triangles or more.
  double whole = 0;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const double area = triangle_area(surface.points, surface.triangles[t]);
    members[parts.of_triangle[t]].push_back(t);
    areas[parts.of_triangle[t]] += area;
    whole += area;
    for (const std::uint32_t other : neighbours[t])
      if (other == kCrowdedEdge) is_at_others[parts.of_triangle[t]] = true;
  }
  std::vector<std::uint32_t> loose;
  for (std::uint32_t p = 0; p < parts.count; ++p)
    if (members[p].size() <= kMax && !is_at_others[p] && areas[p] <= kMaxShare * whole &&
        is_disc_without_inner_vertex(surface, members[p]))
      loose.insert(loose.end(), members[p].begin(), members[p].end());
  std::ranges::sort(loose);
  return loose;
}

}  // namespace lumesh::surfaces
