#pragma once
/// @file The tetrahedra around one vertex as columns of numbers, so that they are measured several at a time.

#include <span>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// Sum over the tetrahedra of 1 / quality, with its derivatives by the position of the vertex while metrics
/// stay.
struct ShapeSums {
  double value = 0;
  Vec3 gradient = Vec3::Zero();
  SymTensor hessian;
};

class StarShapes {
 public:
  /// Begins anew, with no tetrahedra.
  void clear() { count_ = 0; }
  /// Adds the tetrahedron between three vertices and the one that moves, positively oriented in this order.
  /// Copies what does not move.
  void add(const TetMesh& mesh, VertexId a, VertexId b, VertexId c);
  /// Gathers the tetrahedra around a vertex, in this order.
  void gather(const TetMesh& mesh, VertexId vertex, std::span<const TetId> tets);

  /// Cubes of the mean ratios with the vertex at `x`, of metric with logarithm `log_metric`; negative where a
  /// tetrahedron is flat or inverted. In the order of gather(); good until the next call.
  [[nodiscard]] std::span<const double> ratios_cubed_at(const Vec3& x, const SymTensor& log_metric);

  /// @param x  Where every tetrahedron has positive volume.
  [[nodiscard]] ShapeSums sums_at(const Vec3& x, const SymTensor& log_metric);

 private:
  [[nodiscard]] std::size_t blocks() const;
  /// Fills the last block with copies of its first row.
  void complete_last_block();

  std::size_t count_ = 0;
  // In blocks of a few tetrahedra: a, b - a, c - a, their cross product, sum of the logarithms of their
  // metrics.
  std::vector<double> columns_;
  std::vector<double> results_;
};

}  // namespace lumesh::operators
