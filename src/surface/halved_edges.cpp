#include "halved_edges.hpp"

#include <algorithm>

#include "lumesh/mesh/edge_key.hpp"

namespace lumesh::surfaces {
namespace {

/// Adds what halved edges make of a triangle. @param first  Middle of the first edge.
void add_pieces(const Cell<3>& corners, const std::vector<std::uint64_t>& edges, std::uint32_t first,
                std::vector<Cell<3>>& pieces) {
  for (std::size_t s = 0; s < 3; ++s) {
    const std::uint32_t a = corners[s], b = corners[(s + 1) % 3], c = corners[(s + 2) % 3];
    const auto at = std::ranges::lower_bound(edges, edge_key(a, b));
    if (at == edges.end() || *at != edge_key(a, b)) continue;
    const std::uint32_t middle = first + static_cast<std::uint32_t>(at - edges.begin());
    add_pieces({a, middle, c}, edges, first, pieces);
    add_pieces({middle, b, c}, edges, first, pieces);
    return;
  }
  pieces.push_back(corners);
}

}  // namespace

std::vector<std::uint32_t> halve_edges(TriangleMesh& surface, const std::vector<std::uint64_t>& edges) {
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  for (const std::uint64_t edge : edges)
    surface.points.push_back((surface.points[edge >> 32] + surface.points[edge & 0xffffffff]) / 2);
  std::vector<std::uint32_t> whole;
  std::vector<Cell<3>> pieces;
  const std::size_t count = surface.triangles.size();
  for (std::uint32_t t = 0; t < count; ++t) {
    pieces.clear();
    add_pieces(surface.triangles[t], edges, first, pieces);
    surface.triangles[t] = pieces.back();
    pieces.pop_back();
    surface.triangles.insert(surface.triangles.end(), pieces.begin(), pieces.end());
    surface.patches.resize(surface.triangles.size(), std::int32_t{surface.patches[t]});
    whole.insert(whole.end(), pieces.size(), t);
  }
  return whole;
}

}  // namespace lumesh::surfaces
