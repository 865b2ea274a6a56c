#pragma once
// Boundary vertices and triangles around each boundary vertex.

#include <span>

#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::fitting {

class BoundaryStars {
 public:
  BoundaryStars() = default;
  BoundaryStars(const BoundaryModel& boundary, std::size_t vertex_count);

  /// Vertices joined to v by an edge of a boundary triangle and bound by at least v's materials, ascending.
  [[nodiscard]] std::span<const std::uint32_t> neighbours(std::uint32_t v) const { return neighbours_.of(v); }
  /// Numbers of the boundary triangles at v, ascending.
  [[nodiscard]] std::span<const std::uint32_t> triangles(std::uint32_t v) const { return triangles_.of(v); }

 private:
  parallel::Adjacency neighbours_, triangles_;
};

}  // namespace lumesh::fitting
