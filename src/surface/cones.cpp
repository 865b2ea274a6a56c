#include "cones.hpp"

#include <array>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/mesh/triangle_sides.hpp"

namespace lumesh::surfaces {
namespace {

/// Directed edges that close a surface: as often as its triangles run each edge one way more than the other,
/// the other way.
std::vector<std::array<std::uint32_t, 2>> closing_edges(std::span<const Cell<3>> triangles) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for_each_edge(sorted_sides(triangles), [&](std::span<const TriangleSide> sides) {
    int up = 0;
    for (const TriangleSide& side : sides) up += side.runs_up(triangles[side.triangle]) ? 1 : -1;
    for (; up > 0; --up) edges.push_back({sides[0].high, sides[0].low});
    for (; up < 0; ++up) edges.push_back({sides[0].low, sides[0].high});
  });
  return edges;
}

}  // namespace

/// Each connected part of the closing edges is a cone's rim, as each of their ends is a beginning, too.
ClosedByCones::ClosedByCones(std::vector<Vec3> given_points, std::span<const Cell<3>> given_triangles)
    : points(std::move(given_points)),
      triangles(given_triangles.begin(), given_triangles.end()),
      given_count(given_triangles.size()) {
  const std::vector<std::array<std::uint32_t, 2>> edges = closing_edges(given_triangles);
  DisjointSets sets(points.size());
  for (const auto& [from, to] : edges) sets.merge(from, to);
  std::map<std::uint32_t, std::uint32_t> apex_of;
  std::vector<double> ends;
  const std::size_t first = points.size();
  for (const auto& edge : edges) {
    const auto [found, is_new] =
        apex_of.try_emplace(sets.find(edge[0]), static_cast<std::uint32_t>(points.size()));
    const Vec3 start = points[edge[0]];
    if (is_new) {
      points.push_back(Vec3::Zero());
      ends.push_back(0);
      cone_boxes.emplace_back(start, start);
    }
    const std::size_t cone = found->second - first;
    points[found->second] += start;
    ends[cone] += 1;
    cone_boxes[cone] = {cone_boxes[cone].first.cwiseMin(start), cone_boxes[cone].second.cwiseMax(start)};
    triangles.push_back({edge[0], edge[1], found->second});
  }
  for (std::size_t cone = 0; cone < ends.size(); ++cone) points[first + cone] /= ends[cone];
}

}  // namespace lumesh::surfaces
