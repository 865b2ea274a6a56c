#pragma once
/// @file The stage that gives every vertex of a mesh a metric tensor, for every front end.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

struct MeshMetricRequest {
  metric::MetricRequest metric;
  std::string image;              ///< Image whose boundary bends; empty: the mesh's own.
  ImageSelection selection;       ///< Voxels of that image that count.
  std::vector<std::string> keep;  ///< Labels whose cells keep the metric they have.

  void validate() const { metric.validate(); }
};

struct MetricResult {
  double complexity = 0;  ///< Complexity that the mesh sees.
  std::string unmet;      ///< A line where limits keep it from the complexity asked for, else empty.
};

/// The metric of all sources that the request names, within the limits, set at every vertex of the mesh.
/// @param mesh  Compact. @param data  What the sources are made from.
/// @throws what requested_metric() and shape_metric() throw. Parallel inside, bitwise identical for every
/// thread count.
[[nodiscard]] MetricResult make_metric(TetMesh& mesh, const metric::MetricRequest& request,
                                       const metric::MetricLimits& limits, metric::SourceData& data,
                                       Context& context);

struct MeshWithMetric {
  ChangingMesh mesh;  ///< For finish_metric().
  MetricResult result;
};

/// The same for the mesh of a file, or for its part that is free to change.

/// @param input  Outlives the result. @param name  Of the mesh, for messages.
/// @throws Error that names mesh, file or option.
[[nodiscard]] MeshWithMetric give_metric(MixedMesh& input, const std::string& name,
                                         const MeshMetricRequest& request, Context& context);

}  // namespace lumesh
