#pragma once
/// @file What an operator may do; lengths and qualities (mean ratios) are those of the metric.

#include <cmath>
#include <cstddef>
#include <limits>

namespace lumesh::operators {

/// New points.
struct InsertionRules {
  double least_length = 0.6;    ///< To every vertex around, but those of surfaces come first (below).
  double least_height = 0.35;   ///< From an inner point to the faces of a patch nearby.
  double least_quality = 1e-3;  ///< Of each new tetrahedron, in (0, 1).
  int most_cavity_tets = 300;   ///< A cavity that would grow beyond is given up.
};

/// Edges that are drawn together.
struct CollapseRules {
  double most_length = 1.5;     ///< Of each new edge.
  double least_quality = 0.1;   ///< Of each new tetrahedron, or that of the worst before if that is less.
  double least_relative = 0.3;  ///< New worst over old worst quality.
};

/// Vertices that are too many by far.
struct ThinningRules {
  double least_length = 8;      ///< Vertices go into others nearer than this, in their own metric.
  double least_quality = 0.05;  ///< As in CollapseRules, in the vertex's own metric.
};

inline constexpr int kMostRing = 12;
inline constexpr std::size_t kMostFaces = 6;

/// Edges and faces that are replaced.
struct SwapRules {
  int most_ring_tets = 8;               ///< Edges with more tetrahedra around them stay; at most kMostRing.
  std::size_t most_faces = kMostFaces;  ///< That go together in multi-face removal; 1 is the 2-3 swap alone.
  double least_gain = 1e-3;             ///< Of the worst quality.
  double most_length = std::numeric_limits<double>::infinity();  ///< Of each new edge.
  bool repeat = false;  ///< reconnect() tries edges and faces again that failed in the same run.
};

/// Vertices that move.
struct SmoothingRules {
  double length_weight = 1;    ///< Of the edges' lengths against the tetrahedra's shapes, >= 0.
  double most_step = 0.4;      ///< Metric length of one move.
  double least_step = 0.02;    ///< Shorter moves are not made.
  double quality_floor = 0.5;  ///< No tetrahedron may fall below this or the worst one before.
  int halvings = 2;            ///< Of a step that does not improve the sum, >= 1.
};

/// What betters dihedral angles: optimise_vertex(), slide_vertex(), insert_for_angles().
struct AngleRules {
  double least_gain = 1e-3;    ///< Of the worst quality.
  int most_steps = 20;         ///< Of the search for one place.
  int most_cavity_tets = 100;  ///< A cavity that would grow beyond is given up.
  /// Of the edges at a vertex that is moved or put in, in the metric; where they are shorter or longer
  /// already, they may not become more so.
  double least_length = 0, most_length = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool bounds_lengths() const { return least_length > 0 || std::isfinite(most_length); }
  double most_deviation = 0.15;  ///< Of faces from the input surface where a vertex slides, in edge lengths.
  double most_retreat = 0.01;    ///< Of these faces from the vertex's old place; in edge lengths, too.
};

}  // namespace lumesh::operators
