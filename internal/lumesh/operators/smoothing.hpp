#pragma once
/// @file Smoothing in the metric.

#include "lumesh/operators/kernel.hpp"

namespace lumesh::operators {

/// Moves a vertex to lessen the sum of 1 / quality around it plus that of its edges' deviation from unit
/// length: one Newton step with backtracking. No tetrahedron falls below the worst one before or
/// rules.quality_floor, whichever is less. Vertices of patches stay on them.
struct VertexSmoothing {
  static constexpr OperatorId kId = OperatorId::kSmoothing;
  static constexpr auto kMeasure = ShapeMeasure::Kind::kMeanRatio;
  using Target = VertexId;
  SmoothingRules rules = {};
  Outcome operator()(auto& site, VertexId v) const;
};

}  // namespace lumesh::operators
