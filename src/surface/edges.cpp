#include "lumesh/surface/edges.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/geometry/hilbert.hpp"
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

/// Splits points where they are farther apart than `width` along an axis, and calls visit(points) for those
/// that are not.
template <class Visit>
void for_each_cluster(std::span<const Vec3> points, std::span<std::uint32_t> numbers, double width,
                      const Visit& visit, int axis = 0, int whole_along = 0) {
  std::ranges::sort(numbers, [&](std::uint32_t a, std::uint32_t b) {
    return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
  });
  for (std::size_t begin = 0, end = 1; end <= numbers.size(); ++end) {
    if (end < numbers.size() && points[numbers[end]][axis] - points[numbers[end - 1]][axis] <= width)
      continue;
    const std::span<std::uint32_t> part = numbers.subspan(begin, end - begin);
    const int axes = part.size() == numbers.size() ? whole_along + 1 : 1;
    if (axes == 3 || part.size() == 1)
      visit(part);
    else
      for_each_cluster(points, part, width, visit, (axis + 1) % 3, axes);
    begin = end;
  }
}

/// Length of the shortest side that a twentieth of the triangles fall below.
double short_side(const TriangleMesh& surface) {
  std::vector<double> shortest;
  for (const auto& [a, b, c] : surface.triangles)
    shortest.push_back(std::min({(surface.points[b] - surface.points[a]).norm(),
                                 (surface.points[c] - surface.points[b]).norm(),
                                 (surface.points[a] - surface.points[c]).norm()}));
  return value_of_rank(shortest, shortest.size() / 20);
}

}  // namespace

double join_torn_corners(std::vector<Vec3>& points, std::span<const Cell<3>> triangles) {
  constexpr double kShareOfDiagonal = 1e-4, kShareOfSides = 0.25, kLeastShare = 1e-8;
  // A closed surface has a point for two triangles.
  const auto is_torn = [&](std::size_t count) { return count >= 2 * triangles.size(); };
  if (triangles.empty() || !is_torn(points.size())) return 0;
  const TriangleMesh own = weld(points, triangles, {});
  if (own.triangles.empty() || !is_torn(own.points.size())) return 0;
  const double diagonal = bounding_box(own.points).diagonal().norm();
  const double widest = std::min(kShareOfDiagonal * diagonal, kShareOfSides * short_side(own));
  std::vector<std::uint32_t> numbers;
  const std::vector<std::uint8_t> is_used = points_in_use(points.size(), triangles);
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (is_used[v] != 0 && points[v].allFinite()) numbers.push_back(v);
  // The least width that leaves the points of a surface, and that one four times as wide leaves as they are.
  std::vector<Vec3> joined, wider = points;
  std::size_t places = numbers.size(), places_of_wider = places;
  for (double width = kLeastShare * diagonal; width <= widest; width *= 4) {
    joined = std::move(wider);
    places = places_of_wider;
    wider = points;
    places_of_wider = 0;
    for_each_cluster(points, numbers, width, [&](std::span<const std::uint32_t> cluster) {
      ++places_of_wider;
      const Vec3& place = points[*std::ranges::min_element(cluster)];
      for (const std::uint32_t v : cluster) wider[v] = place;
    });
    if (places < triangles.size() && places_of_wider == places) break;
  }
  if (places >= triangles.size()) return 0;
  double farthest = 0;
  for (const std::uint32_t v : numbers) farthest = std::max(farthest, (joined[v] - points[v]).norm());
  points = std::move(joined);
  return farthest;
}

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
