#pragma once
/// @file Pieces of a mesh that are too small to be any of the object's.

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Share of a voxel below which a piece of a mesh is none of the image's: it has been broken off where the
/// object is thinner than elements can follow.
constexpr double kSmallPiece = 0.2;

/// Flag for each vertex: it belongs to a piece, joined through vertices, that is smaller than `min_volume`,
/// and not the largest one. Empty if there are none.
/// @param for_each_tet  for_each_tet(visit) calls visit(corners) for every tetrahedron; asked twice.
/// @param point_of  point_of(vertex).
template <class ForEachTet, class PointOf>
[[nodiscard]] std::vector<std::uint8_t> vertices_of_small_pieces(std::size_t vertex_count, double min_volume,
                                                                 const ForEachTet& for_each_tet,
                                                                 const PointOf& point_of) {
  DisjointSets sets(vertex_count);
  for_each_tet([&](const Cell<4>& tet) {
    for (const std::uint32_t v : tet) sets.merge(tet[0], v);
  });
  std::map<std::uint32_t, double> volumes;
  for_each_tet([&](const Cell<4>& tet) {
    volumes[sets.find(tet[0])] +=
        tetrahedron_volume(point_of(tet[0]), point_of(tet[1]), point_of(tet[2]), point_of(tet[3]));
  });
  if (volumes.size() < 2) return {};
  double largest = 0;
  for (const auto& [root, volume] : volumes) largest = std::max(largest, volume);
  std::erase_if(volumes, [&](const auto& piece) { return piece.second >= std::min(min_volume, largest); });
  if (volumes.empty()) return {};
  std::vector<std::uint8_t> is_small(vertex_count, 0);
  for (std::uint32_t v = 0; v < vertex_count; ++v) is_small[v] = volumes.contains(sets.find(v)) ? 1 : 0;
  return is_small;
}

}  // namespace lumesh
