#pragma once
/// @file One sweep of one operator over the mesh, for every execution (OrderedExecution,
/// SpeculativeExecution).

#include "lumesh/adapt/adapt.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/ordered_execution.hpp"
#include "lumesh/operators/speculative_execution.hpp"

namespace lumesh {

/// Whose edges a splitting sweep looks at.
enum class SplitRank : std::uint8_t { kCurves, kSurfaces, kAll };

/// Splits the edges longer than `longest`, in each tetrahedron the longest one first. Edges longer than 2.5
/// are cut at a third, so that the parts come near to unit length.
/// @param placement   kCentroid: in sweeps of all edges, the centroid of the tetrahedron is tried first.
/// @param arc_weight  Edges of curved patches whose arcs are higher than longest / arc_weight are split, too.
template <class Execution>
void split_long_edges(const operators::Subject& subject, Execution& execution, double longest,
                      double arc_weight, SplitRank rank, PointPlacement placement,
                      const operators::InsertionRules& rules);

/// Collapses every vertex with an edge shorter than `shortest` onto its nearest admissible neighbour, those
/// with the shortest edges first.
template <class Execution>
void collapse_short_edges(const TetMesh& mesh, Execution& execution, double shortest,
                          const operators::CollapseRules& rules);

/// Coarsens by edge collapses where the mesh is much finer than the metric (Operators::thin_out()): a sweep
/// leaves less than half of the vertices. The qualities of the mesh are to be measured afterwards.
template <class Execution>
void thin_out(const TetMesh& mesh, Execution& execution, const operators::ThinningRules& rules);

/// Tries edge and face removal on the tetrahedra whose quality is below `below`.
template <class Execution>
void reconnect(const TetMesh& mesh, Execution& execution, double below, Reconnection which,
               operators::SwapRules rules);

/// Reconnects the tetrahedra whose quality is below `below`, or moves the vertices of those that cannot be.
template <class Execution>
void improve_worst(const TetMesh& mesh, Execution& execution, double below, operators::SwapRules swaps,
                   const operators::SmoothingRules& smoothing);

/// Moves every vertex once.
template <class Execution>
void smooth(Execution& execution, const operators::SmoothingRules& rules);

/// The longest edge in the metric.
[[nodiscard]] double longest_edge(const TetMesh& mesh);

}  // namespace lumesh
