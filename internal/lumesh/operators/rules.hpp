#pragma once
/// @file Limits on operators; lengths and qualities (mean ratios) are those of the metric.

#include <cmath>
#include <cstddef>
#include <limits>

namespace lumesh::operators {

/// Limits on new points.
struct InsertionRules {
  double min_length = 0.6;    ///< Distance to every vertex around; points of surfaces come first, see below.
  double min_height = 0.35;   ///< Height of an inner point over the faces of a patch nearby.
  double min_quality = 1e-3;  ///< Quality of each new tetrahedron, in (0, 1).
  int max_cavity_tets = 300;  ///< A cavity that would grow beyond is given up.
};

/// Limits on edge collapses.
struct CollapseRules {
  double max_length = 1.5;   ///< Length of each new edge.
  double min_quality = 0.1;  ///< Quality of each new tetrahedron, or that of the worst before if less.
  double min_relative_quality = 0.3;  ///< New worst over old worst quality.
};

/// Limits on Thinning, where vertices are too many by far.
struct ThinningRules {
  double min_length = 8;      ///< Vertices are collapsed onto others nearer than this, in their own metric.
  double min_quality = 0.05;  ///< See CollapseRules; in the vertex's own metric.
};

inline constexpr int kMaxRing = 12;
inline constexpr std::size_t kMaxFaces = 6;

/// Limits on edge and face removal.
struct SwapRules {
  int max_ring_tets = 8;              ///< Edges with more tetrahedra around them stay; at most kMaxRing.
  std::size_t max_faces = kMaxFaces;  ///< Faces of one multi-face removal; 1 is the 2-3 swap alone.
  double min_gain = 1e-3;             ///< Gain of the worst quality.
  double max_length = std::numeric_limits<double>::infinity();  ///< Length of each new edge.
  bool repeat = false;  ///< TetReconnection tries edges and faces again that failed in the same run.
};

/// Weights of and limits on vertex moves.
struct SmoothingRules {
  double length_weight = 1;    ///< Weight of the edges' lengths against the tetrahedra's shapes, >= 0.
  double max_step = 0.4;       ///< Metric length of one move.
  double min_step = 0.02;      ///< Shorter moves are not made.
  double quality_floor = 0.5;  ///< No tetrahedron may fall below this or the worst one before.
  int halvings = 2;            ///< Halvings of a step that does not improve the sum, >= 1.
};

/// Limits on operators that improve dihedral angles (angle_optimisation.hpp).
struct AngleRules {
  double min_gain = 1e-3;     ///< Gain of the worst quality.
  int max_steps = 20;         ///< Steps of the search for one place.
  int max_cavity_tets = 100;  ///< A cavity that would grow beyond is given up.
  /// Lengths, in the metric, of the edges at a vertex that is moved or inserted; edges that are shorter or
  /// longer already may not become more so.
  double min_length = 0, max_length = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool bounds_lengths() const { return min_length > 0 || std::isfinite(max_length); }
  /// Distance of a vertex that is inserted from those around it, in the shortest edge there between vertices
  /// of patches; 0: any.
  double min_share_of_patch_edge = 0;
  double max_deviation =
      0.15;                   ///< Deviation of faces from the input surface where a vertex slides, in edges.
  double max_retreat = 0.01;  ///< Distance of these faces from the vertex's old place; in edges, too.
};

}  // namespace lumesh::operators
