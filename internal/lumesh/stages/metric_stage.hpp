#pragma once
/// @file The stage that gives every vertex of a finished mesh a metric tensor, for every front end.

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

struct MeshWithMetric {
  ChangingMesh mesh;  ///< For finish_metric().
  double complexity = 0;
  std::string unmet;  ///< A line where limits keep it from the complexity asked for, else empty.
};

/// @param input  Outlives the result. @param name  Of the mesh, for messages.
/// @throws Error that names mesh, file or option.
[[nodiscard]] MeshWithMetric give_metric(MixedMesh& input, const std::string& name,
                                         const MeshMetricRequest& request, Context& context);

}  // namespace lumesh
