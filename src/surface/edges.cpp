#include "lumesh/surface/edges.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

/// For each point the first of those equal to it.
std::vector<std::uint32_t> first_equal(std::span<const Vec3> points) {
  std::vector<std::uint32_t> order(points.size()), first(points.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [&](std::uint32_t i) { return std::tie(points[i].x(), points[i].y(), points[i].z()); };
  // Points that no triangle uses may be anything, which would break the order.
  std::erase_if(order, [&](std::uint32_t i) { return !points[i].allFinite(); });
  parallel::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && key(order[i - 1]) == key(order[i]) ? first[order[i - 1]] : order[i];
  return first;
}

}  // namespace

TriangleMesh weld(std::span<const Vec3> points, std::span<const Cell<3>> triangles,
                  std::span<const std::int32_t> patches) {
  const std::vector<std::uint32_t> first = first_equal(points);
  PointNumbers numbers(points.size());
  TriangleMesh surface;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Cell<3> corners{};
    for (std::size_t i = 0; i < 3; ++i) corners[i] = first[triangles[t][i]];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    for (std::uint32_t& v : corners) v = numbers.of(v);
    surface.triangles.push_back(corners);
    surface.patches.push_back(patches.empty() ? 0 : patches[t]);
  }
  surface.points = numbers.places(points);
  return surface;
}

EdgeNeighbours edge_neighbours(std::span<const Cell<3>> triangles) {
  EdgeNeighbours neighbours(triangles.size(), {kOpenEdge, kOpenEdge, kOpenEdge});
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> edge) {
    if (edge.size() > 2)
      for (const TriangleSide& side : edge) neighbours[side.triangle][side.side] = kCrowdedEdge;
    if (edge.size() != 2) return;
    neighbours[edge[0].triangle][edge[0].side] = edge[1].triangle;
    neighbours[edge[1].triangle][edge[1].side] = edge[0].triangle;
  });
  return neighbours;
}

bool runs_along(const Cell<3>& corners, std::uint32_t from, std::uint32_t to) {
  for (std::size_t s = 0; s < 3; ++s)
    if (corners[s] == from && corners[(s + 1) % 3] == to) return true;
  return false;
}

Parts turn_alike(TriangleMesh& surface) {
  return turn_alike(surface.triangles, edge_neighbours(surface.triangles));
}

Parts turn_alike(std::vector<Cell<3>>& triangles, const EdgeNeighbours& neighbours) {
  constexpr std::uint32_t kNoPart = ~0U;
  const std::vector<Cell<3>> given = triangles;  // Sides of neighbours are those of triangles as given.
  Parts parts;
  parts.of_triangle.assign(given.size(), kNoPart);
  std::vector<std::uint32_t> stack;
  for (std::uint32_t seed = 0; seed < given.size(); ++seed) {
    if (parts.of_triangle[seed] != kNoPart) continue;
    parts.of_triangle[seed] = parts.count;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (std::size_t s = 0; s < 3; ++s) {
        const std::uint32_t other = neighbours[t][s];
        if (other >= kCrowdedEdge || parts.of_triangle[other] != kNoPart) continue;
        const std::uint32_t a = given[t][s], b = given[t][(s + 1) % 3];
        const bool is_along_mine = runs_along(triangles[t], a, b);
        if (runs_along(triangles[other], a, b) == is_along_mine)
          std::swap(triangles[other][1], triangles[other][2]);
        parts.of_triangle[other] = parts.count;
        stack.push_back(other);
      }
    }
    ++parts.count;
  }
  return parts;
}

}  // namespace lumesh::surfaces
