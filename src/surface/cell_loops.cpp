#include "cell_loops.hpp"

#include <algorithm>
#include <cstddef>

namespace lumesh::surfaces {
namespace {

constexpr std::uint8_t kNoEdge = 12;

/// Corners of the faces of a cell, anticlockwise seen from outside.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kCellFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

std::uint8_t edge_between(std::uint8_t a, std::uint8_t b) {
  const std::uint8_t low = std::min(a, b);
  const int way = a ^ b;
  for (std::size_t e = 0; e < kCellEdges.size(); ++e)
    if (kCellEdges[e].corner == low && 1 << kCellEdges[e].axis == way) return static_cast<std::uint8_t>(e);
  return kNoEdge;
}

/// For each edge that crosses the surface, the next one of its loop: within each face, around each run of
/// inner corners, from where an anticlockwise walk enters the run to where it leaves it.
std::array<std::uint8_t, 12> next_edges(unsigned inner) {
  std::array<std::uint8_t, 12> next;
  next.fill(kNoEdge);
  const auto is_inner = [&](std::uint8_t corner) { return (inner >> corner & 1) != 0; };
  for (const auto& face : kCellFaces)
    for (std::size_t i = 0; i < 4; ++i) {
      if (is_inner(face[i]) || !is_inner(face[(i + 1) % 4])) continue;
      std::size_t end = i + 1;
      while (is_inner(face[(end + 1) % 4])) ++end;
      next[edge_between(face[i], face[(i + 1) % 4])] = edge_between(face[end % 4], face[(end + 1) % 4]);
    }
  return next;
}

std::array<std::vector<CellLoop>, 256> loops_of_all() {
  std::array<std::vector<CellLoop>, 256> all;
  for (unsigned inner = 0; inner < all.size(); ++inner) {
    std::array<std::uint8_t, 12> next = next_edges(inner);
    for (std::size_t first = 0; first < next.size(); ++first) {
      CellLoop loop;
      for (auto e = static_cast<std::uint8_t>(first); next[e] != kNoEdge;) {
        loop.push_back(e);
        const std::uint8_t behind = next[e];
        next[e] = kNoEdge;
        e = behind;
      }
      if (!loop.empty()) all[inner].push_back(loop);
    }
  }
  return all;
}

}  // namespace

const std::array<std::vector<CellLoop>, 256>& cell_loops() {
  static const std::array<std::vector<CellLoop>, 256> kLoops = loops_of_all();
  return kLoops;
}

}  // namespace lumesh::surfaces
