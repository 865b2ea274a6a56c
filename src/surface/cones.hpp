#pragma once
// Cones over the open edges of a surface, with which it winds around each point a whole number of times.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// A surface closed by a cone over each connected part of its open edges: those that its triangles run one
/// way more often than the other. Threads: parallel inside, the same for every thread count.
struct ClosedByCones {
  ClosedByCones(std::vector<Vec3> given_points, std::span<const Cell<3>> given_triangles);
  [[nodiscard]] std::span<const Cell<3>> cones() const { return std::span(triangles).subspan(given_count); }

  std::vector<Vec3> points;        ///< The given ones, then the apexes.
  std::vector<Cell<3>> triangles;  ///< The given ones, then those of the cones.
  std::size_t given_count;
  std::vector<std::pair<Vec3, Vec3>> cone_boxes;  ///< One for each apex: the lowest and highest corners.
};

}  // namespace lumesh::surfaces
