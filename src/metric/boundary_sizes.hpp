#pragma once
/// @file Sizes that a boundary which stays as it is imposes on what lies next to it.

#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::metric {

/// Along a frozen boundary no edge can become what a metric asks for. Near it the metric therefore goes over,
/// at the growth of sizes that is allowed, to one in which the boundary's own triangles are regular; across
/// the boundary sizes stay those that are wanted. Source of the idea: required edges in Mmg (Dapogny et al.
/// 2014, doi:10.1016/j.jcp.2014.01.005), whose sizes are imposed on their surroundings. The tensor,
/// 3/2 (sum of e e^T)^-1: docs/stages/metric.md, "A boundary that stays".
class BoundarySizes {
 public:
  /// @param mesh    Compact. @param growth  > 1, of sizes from one edge to the next.
  /// @param faces   Those of the mesh that are frozen; at least one.
  BoundarySizes(const TetMesh& mesh, const BoundaryFaces& faces, double growth);

  /// The tensor that takes the place of the wanted one at a vertex.
  [[nodiscard]] SymTensor met_at(VertexId v, const SymTensor& wanted) const;

 private:
  /// Sizes that the triangles around a vertex of the boundary impose.
  struct Place {
    SymTensor imposed;  ///< 0 along `across`.
    Vec3 across =
        Vec3::Zero();      ///< The direction in which they leave the size open; 0 where creases leave none.
    double min_along = 0;  ///< Smallest eigenvalue of the imposed tensor, but for `across`.
  };
  struct ClosestPoint {
    double distance = 0;
    std::uint32_t vertex = 0;  ///< Vertex of the boundary, nearby.
  };
  void measure_places(const TetMesh& mesh, const BoundaryFaces& faces);

  double growth_;
  std::vector<Place> places_;          // Per vertex; nothing for those inside.
  std::vector<ClosestPoint> closest_;  // Per vertex.
};

}  // namespace lumesh::metric
