#include "vertex_blocks.hpp"

#include <algorithm>
#include <utility>

#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

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

namespace {

/// From the last bits of the indices along the axes (cube_key).
std::size_t class_of(std::uint64_t block) {
  return (block & 1) | (block >> 20 & 2) | (block >> 40 & 4);
}

}  // namespace

VertexBlocks make_vertex_blocks(const WorkMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  const double block_mm = 2 * longest_edge_mm(mesh);  // more than once would do
  struct Entry {
    std::uint64_t block;
    std::uint32_t vertex;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> entries(vertices.size());
  parallel::for_each_index(entries.size(), [&](std::size_t i) {
    entries[i] = {cube_key(cube_of(mesh.positions[vertices[i]], block_mm)), vertices[i]};
  });
  parallel::sort(entries.begin(), entries.end());
  VertexBlocks blocks;
  for (std::size_t i = 0; i < entries.size();) {
    const std::uint64_t block = entries[i].block;
    std::vector<VertexBlocks::Block>& of_class = blocks.classes[class_of(block)];
    of_class.emplace_back();
    for (; i < entries.size() && entries[i].block == block; ++i) of_class.back().push_back(entries[i].vertex);
  }
  return blocks;
}

void keep_vertices(VertexBlocks& blocks, const std::vector<std::uint32_t>& kept) {
  for (std::vector<VertexBlocks::Block>& of_class : blocks.classes) {
    parallel::for_each_index(of_class.size(), 16, [&](std::size_t b) {
      VertexBlocks::Block left;
      for (const std::uint32_t v : of_class[b]) {
        const auto at = std::ranges::lower_bound(kept, v);
        if (at != kept.end() && *at == v) left.push_back(static_cast<std::uint32_t>(at - kept.begin()));
      }
      of_class[b] = std::move(left);
    });
  }
}

}  // namespace lumesh::fitting
