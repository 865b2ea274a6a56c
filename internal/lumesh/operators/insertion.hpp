#pragma once
/// @file Insertion of vertices, into the cavity of all tetrahedra whose circumsphere in the new vertex's
/// metric holds it (insphere test, corrected until the cavity is star-shaped). Inner vertices that encroach
/// on a new vertex of a surface are collapsed onto it afterwards. Sources: Loseille and Alauzet 2009,
/// doi:10.1007/978-3-642-04319-2_33; Borouchaki, George et al. 1997, doi:10.1016/S0168-874X(96)00057-1.

#include "lumesh/operators/kernel.hpp"

namespace lumesh::operators {

/// Inserts a vertex on an edge, `fraction` of its metric length from the first end. An edge where it failed
/// in this run is not tried again before both ends saw a change.
struct EdgeSplit {
  static constexpr OperatorId kId = OperatorId::kInsertion;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kMeanRatio;
  using Target = TetEdge;
  double fraction = 0.5;
  InsertionRules rules = {};
  bool would_fail(auto& site, const TetEdge& edge) const;
  Outcome operator()(auto& site, const TetEdge& edge) const;
};

/// Inserts a vertex at the centroid of a tetrahedron.
struct CentroidInsertion {
  static constexpr OperatorId kId = OperatorId::kInsertion;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kMeanRatio;
  using Target = TetId;
  InsertionRules rules = {};
  Outcome operator()(auto& site, TetId t) const;
};

}  // namespace lumesh::operators
