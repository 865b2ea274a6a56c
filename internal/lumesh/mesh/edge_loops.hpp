#pragma once
/// @file Closed curves that edges make.

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
