#pragma once
/// @file The stage that adapts a mesh to a metric, for every front end.

#include <string>
#include <vector>

#include "lumesh/adapt/adapt_options.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh {

struct AdaptRequest {
  BoundaryOptions boundary;  ///< The image and the patches that stay come from the front end.
  std::string image_name;    ///< Name of that image, for messages.
  bool allows_pieces = false;
  AdaptOptions adapt;

  void describe(OptionList& list);
  void validate() const { adapt.validate(); }
};

/// Metric that a mesh is adapted to, and how large it makes the mesh.
struct AdaptTarget {
  metric::MetricField field;
  double complexity = 0;  ///< Complexity to which sizes are scaled; 0: they stay as the field says.
  double seen = 0;        ///< Complexity of the field on the mesh; unused where sizes are scaled.
};

/// The metric that the mesh carries, as shape_metric() with these limits left it. Where they kept it from
/// their complexity, sizes stay: scaled ones would break the limits.
/// @param mesh  Compact, with metrics. Parallel inside, bitwise identical for every thread count.
[[nodiscard]] AdaptTarget target_of_metric(const TetMesh& mesh, const metric::MetricLimits& limits,
                                           Context& context);

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

/// Adapts the mesh to the target along its boundary, and gives it the patches again that it had.
/// @param name  Name of the mesh, for messages.
/// @throws Error{kBadInput} that names the mesh, if it has several pieces and the request does not allow
/// them, and what check_fits_memory() throws; what adapt() and AdaptedBoundary throw, with the name of the
/// image where there is one.
[[nodiscard]] AdaptResult adapt_mesh(TetMesh& mesh, const std::string& name, AdaptTarget target,
                                     const AdaptRequest& request, Context& context);

}  // namespace lumesh
