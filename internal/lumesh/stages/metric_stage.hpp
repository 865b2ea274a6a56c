#pragma once
/// @file The stage that gives every vertex of a mesh a metric tensor, for every front end.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {

struct MeshMetricRequest {
  std::string mesh;  ///< Path.
  metric::MetricRequest metric;
  std::string image;              ///< Image whose boundary bends; empty: the mesh's own.
  ImageSelection selection;       ///< Voxels of that image that count.
  std::vector<std::string> keep;  ///< Labels whose cells keep the metric they have.

  /// @throws Error{kUsage} that names the option.
  void validate() const;
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
  ChangingMesh mesh;
  MetricResult result;
};

/// The metric of make_metric() for a mesh, or for its part that is free to change. Warns where limits keep it
/// from the complexity asked for.
/// @param input  The request's mesh, as read. @throws Error that names mesh, file or option.
/// Parallel inside, bitwise identical for every thread count.
[[nodiscard]] MeshWithMetric give_metric(MixedMesh input, const MeshMetricRequest& request, Context& context);
/// The mesh of the file with that metric, finished.
/// @param making  For the provenance. @throws Error as above, and what read_mesh() throws.
[[nodiscard]] MeshWithMetric give_metric(const MeshMetricRequest& request, const Making& making,
                                         Context& context);

/// @throws Error{kUsage} unless a file of this name can hold a metric, alone or with its mesh.
void require_holds_metric(const std::string& path);
/// Writes the metric of a mesh alone, or with the mesh, as the name of the file says.
/// @throws Error{kBadInput} that names the file.
void write_with_metric(const std::string& path, const MeshView& mesh, Context& context);

}  // namespace lumesh
