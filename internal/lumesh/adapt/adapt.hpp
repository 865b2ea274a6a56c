#pragma once
/// @file Anisotropic mesh adaptation: a tetrahedral mesh and a metric in, a unit mesh of that metric out.

#include "lumesh/adapt/adapt_options.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/patch_shapes.hpp"

namespace lumesh {

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
