#pragma once
/// @file Edges where faces end, and the closed curves that they make.

#include <array>
#include <cstdint>
#include <map>
#include <set>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/mesh/edge_key.hpp"

namespace lumesh {

/// The vertices of an edge, the lower one first.
[[nodiscard]] inline std::array<std::uint32_t, 2> ends_of_edge(std::uint64_t edge) {
  return {static_cast<std::uint32_t>(edge >> 32), static_cast<std::uint32_t>(edge)};
}

/// Notes the edges of a face: of all faces noted, those with one face are left.
template <class Corners>
void toggle_edges(const Corners& corners, std::set<std::uint64_t>& rim) {
  for_each_edge_of(corners, [&](std::uint32_t from, std::uint32_t to) {
    if (const std::uint64_t edge = edge_key(from, to); !rim.insert(edge).second) rim.erase(edge);
  });
}

/// How many connected curves edges make. @param edges  By edge_key().
[[nodiscard]] inline std::size_t loop_count(const std::set<std::uint64_t>& edges) {
  std::map<std::uint32_t, std::uint32_t> number;
  for (const std::uint64_t edge : edges)
    for (const std::uint32_t v : ends_of_edge(edge))
      number.try_emplace(v, static_cast<std::uint32_t>(number.size()));
  DisjointSets joined(number.size());
  std::size_t loops = number.size();
  for (const std::uint64_t edge : edges) {
    const auto [a, b] = ends_of_edge(edge);
    const std::uint32_t one = joined.find(number.at(a)), other = joined.find(number.at(b));
    if (one == other) continue;
    joined.merge(one, other);
    --loops;
  }
  return loops;
}

}  // namespace lumesh
