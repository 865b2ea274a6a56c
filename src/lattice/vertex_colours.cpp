#include "vertex_colours.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr std::uint8_t kIdle = 255;  // not to be coloured
constexpr std::uint8_t kUncoloured = 254;

/// Pseudo-random, different for different vertices.
std::uint64_t priority(std::uint32_t v) {
  std::uint64_t x = (std::uint64_t{v} + 1) * 0x9e3779b97f4a7c15ULL;
  x ^= x >> 31;
  return (x << 32) | v;
}

}  // namespace

std::vector<std::uint32_t> vertices_near_boundary(const WorkMesh& mesh, const BoundaryModel& boundary) {
  constexpr int kRings = 3;
  std::vector<std::uint8_t> ring(mesh.positions.size(), kRings + 1);
  parallel::for_each_index(ring.size(), [&](std::size_t v) {
    if (boundary.sets[v].size() >= 2) ring[v] = 0;
  });
  for (std::uint8_t r = 1; r <= kRings; ++r) {
    const std::vector<std::uint8_t> before = ring;
    parallel::for_each_index(ring.size(), [&](std::size_t v) {
      if (before[v] <= r) return;
      for (const std::uint32_t t : mesh.star(static_cast<std::uint32_t>(v))) {
        for (const std::uint32_t w : mesh.tets[t]) {
          if (before[w] < r) ring[v] = r;
        }
      }
    });
  }
  return parallel::collect<std::uint32_t>(ring.size(), [&](std::size_t v, auto& out) {
    if (ring[v] <= kRings) out.push_back(static_cast<std::uint32_t>(v));
  });
}

VertexColours colour_vertices(const WorkMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<std::uint8_t> colour(mesh.positions.size(), kIdle);
  for (const std::uint32_t v : vertices) colour[v] = kUncoloured;
  std::vector<std::uint32_t> waiting = vertices;
  std::vector<std::uint8_t> chosen;
  while (!waiting.empty()) {
    chosen.assign(waiting.size(), kUncoloured);
    parallel::for_each_index(waiting.size(), [&](std::size_t i) {
      const std::uint32_t v = waiting[i];
      const std::uint64_t own = priority(v);
      std::uint64_t used = 0;
      for (const std::uint32_t t : mesh.star(v)) {
        for (const std::uint32_t w : mesh.tets[t]) {
          if (w == v || colour[w] == kIdle) continue;
          if (colour[w] == kUncoloured) {
            if (priority(w) > own) return;
          } else {
            used |= std::uint64_t{1} << colour[w];
          }
        }
      }
      chosen[i] = static_cast<std::uint8_t>(std::countr_one(used));
    });
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (chosen[i] != kUncoloured) colour[waiting[i]] = chosen[i];
    }
    waiting = parallel::collect<std::uint32_t>(waiting.size(), [&](std::size_t i, auto& out) {
      if (chosen[i] == kUncoloured) out.push_back(waiting[i]);
    });
  }
  VertexColours classes;
  for (const std::uint32_t v : vertices) {
    LUMESH_ASSERT(colour[v] < 64);
    if (colour[v] >= classes.size()) classes.resize(colour[v] + std::size_t{1});
    classes[colour[v]].push_back(v);
  }
  return classes;
}

void keep_vertices(VertexColours& colours, const std::vector<std::uint32_t>& kept) {
  parallel::for_each_index(
      colours.size(),
      [&](std::size_t c) {
        std::vector<std::uint32_t> left;
        for (const std::uint32_t v : colours[c]) {
          const auto at = std::lower_bound(kept.begin(), kept.end(), v);
          if (at != kept.end() && *at == v) left.push_back(static_cast<std::uint32_t>(at - kept.begin()));
        }
        colours[c] = std::move(left);
      },
      1);
}

}  // namespace lumesh
