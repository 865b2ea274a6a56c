#pragma once
/// @file The stage that adapts a mesh to a metric, for every front end.

#include <string>
#include <vector>

#include "lumesh/adapt/adapt_options.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"

namespace lumesh {

struct AdaptRequest {
  BoundaryOptions boundary;  ///< The image and the patches that stay come from the front end.
  bool allows_pieces = false;
  AdaptOptions adapt;

  void describe(OptionList& list);
  void validate() const { adapt.validate(); }
};

/// Volume of a label before and after.
struct LabelChange {
  Label label = kBackground;
  double before_mm3 = 0, after_mm3 = 0;

  [[nodiscard]] double percent() const { return 100 * (after_mm3 / before_mm3 - 1); }
};

struct AdaptResult {
  AdaptReport report;
  std::size_t patches_on_image = 0;  ///< Patches that followed the image.
  std::vector<LabelChange> volumes = {};
  /// Warnings: of vertices beyond the image, of labels whose volume has changed, and of more vertices than
  /// the sizes ask for.
  std::vector<std::string> notes = {};
};

/// Pieces that no face joins are often forgotten specks of a segmentation, in which a flow has no way out.
/// @throws Error{kBadInput} if the mesh has several and the request does not allow them; without a name.
void require_one_piece(const TetMesh& mesh, const AdaptRequest& request);

/// Adapts the mesh to the field along its boundary, and gives it the patches again that it had.
/// @param complexity  Of the adapted mesh; 0: as the field says. @throws what adapt() and AdaptedBoundary
/// throw.
[[nodiscard]] AdaptResult adapt_mesh(TetMesh& mesh, metric::MetricField& field, const AdaptRequest& request,
                                     double complexity, Context& context);

}  // namespace lumesh
