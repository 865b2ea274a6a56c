#pragma once
/// @file Anisotropic mesh adaptation: a tetrahedral mesh and a metric in, a unit mesh of that metric out.

#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "lumesh/adapt/execution_kind.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/operators.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/settling.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh {

class OptionList;

/// Which tetrahedra of low quality are tried anew in each sweep of reconnection.
enum class Reconnection : std::uint8_t {
  kOriginal,   ///< All.
  kOptimised,  ///< Those around which something changed since the last trial (the paper's algorithm 2,
               ///< refined).
};

/// Where new points of the volume are put; those of curves and surfaces split edges.
enum class PointPlacement : std::uint8_t {
  kEdge,      ///< On the longest edges.
  kCentroid,  ///< On the centroids of tetrahedra with long edges, else on these (mpp 5).
};

/// Options of adapt(); describe() says what each means and which values it takes.
struct AdaptOptions {
  double split_above = std::numbers::sqrt2;
  double collapse_below = 0.7;
  double least_length = 0.6;
  int quality_passes = 2;
  int smoothing_passes = 1;
  double reconnect_below = 0.6;

  PointPlacement placement = PointPlacement::kEdge;
  Reconnection reconnection = Reconnection::kOptimised;
  ExecutionKind execution = ExecutionKind::kOrdered;
  parallel::TeamOptions team = {};
  bool as_cdt3d_with_metric = true;  ///< What its parameters met, meval and reconstruct ask for: always so.
  operators::KeepWithin keep_within =
      {};  ///< Where vertices of curved patches may be in the end; null: everywhere.

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the field.
  void validate() const;
};

/// One row of what happened: everything since the row before.
struct AdaptPass {
  std::string name;
  double seconds = 0;
  std::uint32_t tets = 0, vertices = 0;  ///< Afterwards.
  operators::OperatorCounts counts;
};

struct AdaptReport {
  std::vector<AdaptPass> passes;
  operators::ExecutionCounts by_thread;  ///< Who did what depends on chance in every execution.
  double complexity = 0;                 ///< Of the metric as the adapted mesh sees it.
  bool complete = true;                  ///< False if the context was cancelled before the end.
};

/// Adapts `mesh` until its edges have about unit length in `field`, then improves its shapes.
///
/// First the mesh is brought to the metric level by level: each level splits the edges longer than a bound,
/// which sinks from the longest edge's length to split_above, curves first, then surfaces, then the volume.
/// New points are put in by cavities that are Delaunay in their metric, so that few tetrahedra are left to
/// repair. Then quality passes reconnect, smooth, collapse and split.
///
/// @param mesh    Any valid mesh; it becomes the adapted one, compact, with the metric of every vertex.
///                Labels and patches stay.
/// @param shapes  One per patch: what its vertices stay on while it is adapted, or that it is kept as it is
///                (operators::shapes_of_patches()).
/// Where the context is cancelled, it ends within the sweep that runs and leaves a valid mesh: the best so
/// far.
/// @throws Error{kBadInput} if the mesh is empty.
/// Sources: Loseille, Menier and Alauzet 2015, doi:10.1016/j.proeng.2015.10.122 (cavities);
/// docs/experiments/adapt.md (what was compared).
AdaptReport adapt(TetMesh& mesh, const metric::MetricField& field, const operators::PatchShapes& shapes,
                  const AdaptOptions& options, Context& context);

/// The same, with the sizes of `field` scaled by one factor so that the adapted mesh sees the complexity
/// asked for, within 2 %. Measured on the mesh itself, because a formula or a coarse background says little
/// about what a mesh will see: where the first mesh misses, it is adapted again.
/// @param complexity  > 0; the mesh will have about twice as many vertices.
AdaptReport adapt_to_complexity(TetMesh& mesh, metric::MetricField& field,
                                const operators::PatchShapes& shapes, double complexity,
                                const AdaptOptions& options, Context& context);

}  // namespace lumesh
