#include "surface_stars.hpp"

#include <algorithm>

#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

struct Lists {
  std::vector<std::uint32_t> begin, items;
};

/// From pairs "owner << 32 | item" to one ascending list for each owner, without repetitions.
Lists lists_of(std::vector<std::uint64_t> pairs, std::size_t owners) {
  parallel::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Lists lists;
  lists.begin.resize(owners + 1);
  lists.items.resize(pairs.size());
  const auto owner = [&](std::size_t i) { return static_cast<std::size_t>(pairs[i] >> 32); };
  parallel::for_each_index(pairs.size() + 1, [&](std::size_t i) {
    // Every owner after the last pair's, up to this pair's, begins here.
    const std::size_t first = i == 0 ? 0 : owner(i - 1) + 1;
    const std::size_t last = i == pairs.size() ? owners : owner(i);
    for (std::size_t o = first; o <= last; ++o) lists.begin[o] = static_cast<std::uint32_t>(i);
    if (i < pairs.size()) lists.items[i] = static_cast<std::uint32_t>(pairs[i]);
  });
  return lists;
}

}  // namespace

SurfaceStars::SurfaceStars(const BoundaryModel& boundary, std::size_t vertex_count) {
  const std::vector<BoundaryTriangle>& triangles = boundary.triangles;
  auto edges = parallel::collect<std::uint64_t>(triangles.size(), [&](std::size_t n, auto& out) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangles[n].vertices[i];
      const std::uint32_t b = triangles[n].vertices[(i + 1) % 3];
      if (boundary.sets[b].contains_all(boundary.sets[a])) out.push_back(std::uint64_t{a} << 32 | b);
      if (boundary.sets[a].contains_all(boundary.sets[b])) out.push_back(std::uint64_t{b} << 32 | a);
    }
  });
  Lists lists = lists_of(std::move(edges), vertex_count);
  neighbours_begin_ = std::move(lists.begin);
  neighbours_ = std::move(lists.items);
  std::vector<std::uint64_t> corners(3 * triangles.size());
  parallel::for_each_index(triangles.size(), [&](std::size_t n) {
    for (std::size_t i = 0; i < 3; ++i)
      corners[3 * n + i] = std::uint64_t{triangles[n].vertices[i]} << 32 | n;
  });
  lists = lists_of(std::move(corners), vertex_count);
  triangles_begin_ = std::move(lists.begin);
  triangles_ = std::move(lists.items);
}

}  // namespace lumesh
