#pragma once
/// @file Edge collapses: the tetrahedra around an edge vanish, one end goes where the other one is. A vertex
/// of a curve stays on it, one of a surface on its patch, corners stay.

#include <span>

#include "lumesh/operators/kernel.hpp"

namespace lumesh::operators {

/// Collapses the first end of an edge onto the other one.
struct EdgeCollapse {
  static constexpr OperatorId kId = OperatorId::kCollapse;
  using Target = TetEdge;
  CollapseRules rules = {};
  Outcome operator()(auto& site, const TetEdge& edge) const;
};

/// Collapses a vertex onto its nearest admissible neighbour, of those at less than `min_length`.
struct VertexCollapse {
  static constexpr OperatorId kId = OperatorId::kCollapse;
  using Target = VertexId;
  double min_length = 1;
  CollapseRules rules = {};
  Outcome operator()(auto& site, VertexId v) const;
};

/// Collapses a vertex onto its nearest admissible neighbour, with an approximate metric, that of the vertex
/// alone: for sweeps in which most vertices go. Vertices that others were collapsed onto stay, so that the
/// rest lies evenly. The stored qualities are those of that metric: measure_qualities() afterwards. Vertices
/// of curved patches stay.
struct Thinning {
  static constexpr OperatorId kId = OperatorId::kCollapse;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kMeanRatio;
  using Target = VertexId;
  std::span<std::uint8_t>
      kept;  ///< Per vertex, 0 at the start of a sweep; 1 where others were collapsed onto it.
  ThinningRules rules = {};
  Outcome operator()(auto& site, VertexId v) const;
};

}  // namespace lumesh::operators
