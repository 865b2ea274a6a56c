#pragma once
/// @file Sizes that a boundary which stays as it is imposes on what lies next to it.

#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::metric {

/// Along a frozen boundary no edge can become what a metric asks for. Near it the metric therefore goes over,
/// at the growth of sizes that is allowed, to one in which the boundary's own triangles are regular; across
/// the boundary sizes stay those that are wanted. Source of the idea: required edges in Mmg (Dapogny et al.
/// 2014, doi:10.1016/j.jcp.2014.01.005), whose sizes are imposed on their surroundings.
class BoundarySizes {
 public:
  /// @param mesh    Compact. @param growth  > 1, of sizes from one edge to the next.
  /// @param faces   Those of the mesh that are frozen; at least one.
  BoundarySizes(const TetMesh& mesh, const BoundaryFaces& faces, double growth);

  /// What takes the place of the wanted tensor at a vertex.
  [[nodiscard]] SymTensor met_at(VertexId v, const SymTensor& wanted) const;

 private:
  /// What the triangles around a vertex of the boundary impose.
  struct Place {
    SymTensor imposed;  ///< 0 along `across`.
    Vec3 across =
        Vec3::Zero();        ///< The direction in which they leave the size open; 0 where creases leave none.
    double least_along = 0;  ///< Least eigenvalue of the imposed tensor, but for `across`.
  };
  struct Foot {
    double distance = 0;
    std::uint32_t vertex = 0;  ///< Of the boundary, nearby.
  };
  void measure_places(const TetMesh& mesh, const BoundaryFaces& faces);

  double growth_;
  std::vector<Place> places_;  // Of all vertices; nothing for those inside.
  std::vector<Foot> feet_;     // Of all vertices.
};

}  // namespace lumesh::metric
