#include "boundary_stars.hpp"

#include <algorithm>

namespace lumesh::fitting {

namespace {

/// The corners of some triangles that are bound by at least a vertex's materials, without the vertex.
void add_neighbours(const BoundaryModel& boundary, std::span<const std::uint32_t> triangles, std::uint32_t v,
                    std::vector<std::uint32_t>& all) {
  const auto first = static_cast<std::ptrdiff_t>(all.size());
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t w : boundary.triangles[t].vertices) {
      if (w != v && boundary.sets[w].contains_all(boundary.sets[v])) all.push_back(w);
    }
  }
  std::sort(all.begin() + first, all.end());
  all.erase(std::unique(all.begin() + first, all.end()), all.end());
}

}  // namespace

BoundaryStars::BoundaryStars(const BoundaryModel& boundary, std::size_t vertex_count) {
  triangles_ = parallel::group_by_owner(
      boundary.triangles.size(),
      vertex_count, [&](std::size_t t) -> const auto& { return boundary.triangles[t].vertices; });
  neighbours_ = parallel::collect_lists(vertex_count, [&](std::size_t v, std::vector<std::uint32_t>& out) {
    add_neighbours(boundary, triangles_.of(v), static_cast<std::uint32_t>(v), out);
  });
}

}  // namespace lumesh::fitting
