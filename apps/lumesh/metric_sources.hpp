#pragma once
/// @file What `lumesh metric` makes a metric of: formulas, tensors, points, a flow, a solution, the
/// boundary's curvature.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh::cli {

struct MetricSources {
  std::string mesh_path, metric_path, formula;
  std::string points_path;
  std::string velocity_path, velocity_array;
  std::string hessian_field;  ///< Point array of the mesh's file, or a .sol or .solb file.
  double norm = 2;
  std::size_t curvature = 0;  ///< How often the flag was given.
  std::string image_path;     ///< Whose boundary bends; none: the mesh's own.
  ImageSelection selection;   ///< Of that image.
  double chord_mm = 0, edges_per_radius = 2;
  std::optional<int> k;  ///< None: as the source's options say.
};

/// All options that name a source.
void add_source_options(CLI::App& command, MetricSources& sources);

/// The intersection of what the sources ask for, or the mesh's own metric where there is none. Several
/// sources have no common scale: where a complexity is wanted, each is scaled to it first.
/// @param limits  Their complexity; their largest size is what the boundary's curvature wants where there is
/// none.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] std::vector<SymTensor> wanted_metric(const MetricSources& sources, const MixedMesh& input,
                                                   const TetMesh& mesh, const metric::MetricLimits& limits,
                                                   Context& context);

}  // namespace lumesh::cli
