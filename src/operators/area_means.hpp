#pragma once
/// @file Means over the triangles around vertices, weighted by area.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::operators {

/// A triangle's value and area.
struct ValueOnArea {
  double value = 0, area = 0;
};

/// The mean around each vertex; 0 where no triangle has an area.
[[nodiscard]] inline std::vector<double> means_around_vertices(std::span<const Cell<3>> triangles,
                                                               std::span<const ValueOnArea> values,
                                                               std::size_t vertices) {
  std::vector<double> means(vertices, 0), areas(vertices, 0);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::uint32_t v : triangles[i]) {
      means[v] += values[i].area * values[i].value;
      areas[v] += values[i].area;
    }
  for (std::size_t v = 0; v < vertices; ++v)
    if (areas[v] > 0) means[v] /= areas[v];
  return means;
}

}  // namespace lumesh::operators
