#pragma once
/// @file Operators that improve the worst dihedral angle, by non-smooth optimisation of a vertex's place.

#include "lumesh/operators/kernel.hpp"

namespace lumesh::operators {

/// Moves a vertex to where the worst dihedral angle around it is best. Vertices of patches stay.
struct VertexOptimisation {
  static constexpr OperatorId kId = OperatorId::kSmoothing;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kDihedralAngles;
  using Target = VertexId;
  AngleRules rules = {};
  Outcome operator()(auto& site, VertexId v) const;
};

/// As VertexOptimisation, for a vertex inside a patch: it moves along Subject::surface, and only where the
/// faces around it stay near that surface and near the vertex's old place.
struct VertexSliding {
  static constexpr OperatorId kId = OperatorId::kSmoothing;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kDihedralAngles;
  using Target = VertexId;
  AngleRules rules = {};
  Outcome operator()(auto& site, VertexId v) const;
};

/// Inserts a vertex near a tetrahedron, in the best of several cavities, at the place where the worst
/// dihedral angle of the new tetrahedra is best; only if that is better than the worst one before. The
/// cavities are the tetrahedra around it or one of its edges on the same side of all patches, with and
/// without the neighbours whose circumsphere holds the middle. Source: Klingner and Shewchuk 2007,
/// doi:10.1007/978-3-540-75103-8_1.
struct AngleInsertion {
  static constexpr OperatorId kId = OperatorId::kInsertion;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kDihedralAngles;
  using Target = TetId;
  AngleRules rules = {};
  Outcome operator()(auto& site, TetId t) const;
};

}  // namespace lumesh::operators
