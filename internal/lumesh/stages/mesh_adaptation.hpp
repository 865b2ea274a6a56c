#pragma once
/// @file The adaptation of a mesh of a file to its metric or another one, for every front end.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

struct MeshAdaptationRequest {
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

/// Adapts the mesh, as adapt_mesh(). Warns of what that notes, and where the image hardly is the mesh's.
/// @param input  Outlives the result; gets the metric that counts. @param name  Of the mesh, for messages.
/// @throws Error{kBadInput} that names the mesh or the image.
[[nodiscard]] AdaptedMesh adapt_mesh(MixedMesh& input, const std::string& name,
                                     const MeshAdaptationRequest& request, Context& context);

}  // namespace lumesh
