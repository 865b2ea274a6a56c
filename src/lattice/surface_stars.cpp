#include "surface_stars.hpp"

#include <algorithm>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

/// The corners of some triangles that are bound by at least a vertex's materials, without the vertex.
void find_neighbours(const BoundaryModel& boundary, std::span<const std::uint32_t> triangles, std::uint32_t v,
                     std::vector<std::uint32_t>& found) {
  found.clear();
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t w : boundary.triangles[t].vertices) {
      if (w != v && boundary.sets[w].contains_all(boundary.sets[v])) found.push_back(w);
    }
  }
  sort_unique(found);
}

}  // namespace

SurfaceStars::SurfaceStars(const BoundaryModel& boundary, std::size_t vertex_count) {
  triangles_ = group_by_owner(
      boundary.triangles.size(),
      vertex_count, [&](std::size_t t) -> const auto& { return boundary.triangles[t].vertices; });
  neighbours_.ranges.resize(vertex_count);
  constexpr std::size_t kBlock = 4096;
  std::vector<std::vector<std::uint32_t>> parts((vertex_count + kBlock - 1) / kBlock);
  parallel::for_each_block(vertex_count, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> found;
    for (std::size_t v = begin; v < end; ++v) {
      const auto vertex = static_cast<std::uint32_t>(v);
      find_neighbours(boundary, triangles_.of(vertex), vertex, found);
      neighbours_.ranges[v].begin = static_cast<std::uint32_t>(parts[b].size());
      parts[b].insert(parts[b].end(), found.begin(), found.end());
      neighbours_.ranges[v].end = static_cast<std::uint32_t>(parts[b].size());
    }
  });
  for (std::size_t b = 0; b < parts.size(); ++b) {
    const auto shift = static_cast<std::uint32_t>(neighbours_.items.size());
    const std::size_t end = std::min(vertex_count, (b + 1) * kBlock);
    for (std::size_t v = b * kBlock; v < end; ++v) {
      neighbours_.ranges[v].begin += shift;
      neighbours_.ranges[v].end += shift;
    }
    neighbours_.items.insert(neighbours_.items.end(), parts[b].begin(), parts[b].end());
  }
}

}  // namespace lumesh
