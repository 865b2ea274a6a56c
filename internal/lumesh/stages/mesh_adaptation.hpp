#pragma once
/// @file The adaptation of a mesh of a file to its metric or another one, for every front end.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {

struct MeshAdaptationRequest {
  std::string mesh;               ///< Path.
  AdaptRequest stage;             ///< Without the image and frozen patches, which the stage finds.
  std::vector<std::string> keep;  ///< Labels whose cells stay as they are.
  metric::TensorSource tensors;   ///< In place of the metric that the mesh carries, …
  metric::AnalyticSource analytic;
  double complexity = 0, gradation = 0;  ///< 0: as the metric says.
  std::string image;                     ///< Image that the surface follows; empty: the mesh's own surface.
  ImageSelection selection;              ///< Voxels of that image that count.
  InputCuts cuts;                        ///< Cuts of that image.

  /// The metric, and how large it is.
  void describe_metric(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

struct AdaptedMesh {
  ChangingMesh mesh;
  AdaptResult result;
};

/// Adapts a mesh, as adapt_mesh() of the stage. Warns of what that notes, and where the image hardly is the
/// mesh's.
/// @param input  The request's mesh, as read. @throws Error{kBadInput} that names the mesh or the image.
/// Parallel inside.
[[nodiscard]] AdaptedMesh adapt_mesh(MixedMesh input, const MeshAdaptationRequest& request, Context& context);
/// The mesh of the file, adapted and finished.
/// @param making  For the provenance. @throws Error as above, and what read_mesh() throws.
[[nodiscard]] AdaptedMesh adapt_mesh(const MeshAdaptationRequest& request, const Making& making,
                                     Context& context);

}  // namespace lumesh
