#pragma once
/// @file The faces of a patch around a vertex that may slide along it.

#include <array>
#include <vector>

#include "lumesh/operators/input_surface.hpp"
#include "lumesh/operators/rules.hpp"
#include "neighbourhoods.hpp"

namespace lumesh::operators {

class SurfaceFan {
 public:
  /// @param v     Inside a patch.
  /// @param ball  Around v.
  SurfaceFan(const TetMesh& mesh, VertexId v, const VertexBall& ball);

  /// Mean length of the edges at the vertex.
  [[nodiscard]] double edge_length() const { return edge_length_; }
  /// Mean of the faces' normals, by their areas.
  [[nodiscard]] Vec3 normal() const;
  /// True if the fan with its centre at `to` keeps its normals by and large, lies near the input surface, and
  /// near the centre as it is.
  [[nodiscard]] bool fits(const Vec3& to, const InputSurface& surface, const AngleRules& rules) const;

 private:
  Vec3 centre_;
  PatchId patch_;
  double edge_length_ = 0;
  std::vector<std::array<Vec3, 2>> rim_;  // The corners of each face after the centre.
};

}  // namespace lumesh::operators
