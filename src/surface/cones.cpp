#include "cones.hpp"

#include <array>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/surface/winding.hpp"

namespace lumesh::surfaces {

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
