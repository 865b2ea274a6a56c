#pragma once
/// @file Limits how fast the sizes of a metric grow from vertex to vertex.

#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::metric {

/// Growth where none is given.
inline constexpr double kUsualGrowth = 1.5;

struct GradationOptions {
  double growth = kUsualGrowth;  ///< Of sizes from one edge of unit length to the next, > 1.
  double physical_share =
      0.125;                ///< 0: ellipsoids grow as a whole and stay as stretched as they are; 1: every
                            ///< axis grows for itself, so that far away they become round. In [0, 1].
  double tolerance = 0.01;  ///< Sweeps go on while a vertex's ln sqrt(det M) changes by more.
  int max_sweeps = 100;
};

/// Lessens the sizes of the mesh's metric until none grows faster along an edge than allowed: every vertex's
/// metric is intersected with its neighbours', grown along the edges between them. Sizes never become larger.
/// Qualities are not measured anew. Parallel inside, bitwise identical for every thread count.
/// @return the sweeps it took.
/// @throws Error{kUsage} that names an option out of its range.
/// Source: Alauzet 2010, doi:10.1016/j.finel.2009.06.028, eq. (9) of section 4.1 (growth in metric space),
/// eq. (10) (in physical space) and eq. (11) of section 5.1 (along edges); how the first two are mixed:
/// docs/stages/metric.md, "Gradation".
int limit_gradation(TetMesh& mesh, const GradationOptions& options = {});

}  // namespace lumesh::metric
