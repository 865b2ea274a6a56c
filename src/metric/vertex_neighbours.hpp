#pragma once
/// @file Which vertices of a mesh are neighbours.

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

/// The vertices that share an edge with each vertex, ascending.
class VertexNeighbours {
 public:
  explicit VertexNeighbours(const TetMesh& mesh)
      : VertexNeighbours(mesh.vertex_slots(), directed_edges(mesh)) {}

  /// @param edges  Each as from << 32 | to, in any order, any number of times.
  VertexNeighbours(std::size_t vertices, std::vector<std::uint64_t> edges) {
    parallel::sort_unique(edges);
    starts_.assign(vertices + 1, 0);
    items_.reserve(edges.size());
    for (const std::uint64_t edge : edges) {
      ++starts_[(edge >> 32) + 1];
      items_.push_back(static_cast<std::uint32_t>(edge));
    }
    for (std::size_t v = 1; v < starts_.size(); ++v) starts_[v] += starts_[v - 1];
  }

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t v) const {
    return std::span(items_).subspan(starts_[v], starts_[v + 1] - starts_[v]);
  }

  /// Vertices within `rings` edges of v or more, until there are `wanted`, without v; v's own neighbours
  /// first.
  [[nodiscard]] std::vector<std::uint32_t> about(std::size_t v, int rings, std::size_t wanted) const {
    constexpr int kMaxRings = 4;
    std::vector<std::uint32_t> found = {static_cast<std::uint32_t>(v)}, ring;
    std::size_t reached = 0;  // Those before it have been looked at.
    for (int r = 0; r < kMaxRings && (r < rings || found.size() <= wanted); ++r) {
      ring.clear();
      for (; reached < found.size(); ++reached)
        for (const std::uint32_t w : of(found[reached])) ring.push_back(w);
      sort_unique(ring);
      std::vector<std::uint32_t> before(found);
      std::sort(before.begin(), before.end());
      std::set_difference(ring.begin(), ring.end(), before.begin(), before.end(), std::back_inserter(found));
    }
    found.erase(found.begin());
    return found;
  }

 private:
  static std::vector<std::uint64_t> directed_edges(const TetMesh& mesh) {
    return parallel::collect_blocks<std::uint64_t>(
        mesh.tet_slots(), kBlock, [&](std::size_t begin, std::size_t end, std::vector<std::uint64_t>& out) {
          for (std::size_t i = begin; i < end; ++i) {
            const TetId t(static_cast<std::uint32_t>(i));
            if (!mesh.alive(t)) continue;
            for (const auto& [k, l] : kTetEdges) {
              const std::uint64_t a = mesh.vertex(t, k).value, b = mesh.vertex(t, l).value;
              out.push_back(a << 32 | b);
              out.push_back(b << 32 | a);
            }
          }
        });
  }

  static constexpr std::size_t kBlock = 4096;
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> items_;
};

}  // namespace lumesh::metric
