#pragma once
/// @file The sweeps of adapt(), for every operators::Execution.

#include "lumesh/adapt/adapt.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/ordered_execution.hpp"
#include "lumesh/operators/speculative_execution.hpp"

namespace lumesh {

/// Whose edges a splitting sweep looks at.
enum class SplitRank : std::uint8_t { kCurves, kSurfaces, kAll };

/// Sweeps of one operator each over the mesh.
template <operators::Execution Execution>
struct Passes {
  const operators::Subject& subject;
  Execution& execution;

  /// Splits the edges longer than `longest`, in each tetrahedron the longest one first. Edges longer than 2.5
  /// are cut at a third, so that the parts come near to unit length.
  /// @param placement   kCentroid: in sweeps of all edges, the centroid of the tetrahedron is tried first.
  /// @param arc_weight  Edges of curved patches whose arcs are higher than longest / arc_weight are split,
  /// too.
  void split_long_edges(double longest, double arc_weight, SplitRank rank, PointPlacement placement,
                        const operators::InsertionRules& rules) const;

  /// Collapses every vertex with an edge shorter than `shortest` onto its nearest admissible neighbour, those
  /// with the shortest edges first.
  void collapse_short_edges(double shortest, const operators::CollapseRules& rules) const;

  /// Coarsens by edge collapses where the mesh is much finer than the metric (operators::Thinning): a sweep
  /// leaves less than half of the vertices. The qualities of the mesh are to be measured afterwards.
  void thin_out(const operators::ThinningRules& rules) const;

  /// Tries edge and face removal on the tetrahedra whose quality is below `below`.
  void reconnect(double below, Reconnection which, operators::SwapRules rules) const;

  /// Reconnects the tetrahedra whose quality is below `below`, or moves the vertices of those that cannot be.
  void improve_worst(double below, operators::SwapRules swaps,
                     const operators::SmoothingRules& smoothing) const;

  /// Moves every vertex once.
  void smooth(const operators::SmoothingRules& rules) const;
};

/// The longest edge in the metric.
[[nodiscard]] double longest_edge(const TetMesh& mesh);

}  // namespace lumesh
