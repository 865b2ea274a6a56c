#include "lumesh/stages/adapt_stage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/metric/background_field.hpp"
#include "vertices_outside.hpp"

namespace lumesh {

void AdaptRequest::describe(OptionList& list) {
  boundary.describe(list);
  list.flag("allow_pieces", allows_pieces, "Take meshes of several pieces that no face joins, too");
  adapt.describe(list);
}

namespace {

/// Pieces that no face joins are often forgotten specks of a segmentation, in which a flow has no way out.
void require_one_piece(const TetMesh& mesh, const AdaptRequest& request) {
  const std::uint32_t pieces = request.allows_pieces ? 1 : count_pieces(mesh);
  if (pieces > 1)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format(
            "has {} pieces that no face joins; make it of the largest one ({} of the image), or give {}",
            pieces, option_name("largest_component"), option_name("allow_pieces")));
}

std::vector<LabelChange> changes_of(const std::map<Label, double>& before,
                                    const std::map<Label, double>& after) {
  std::vector<LabelChange> changes;
  for (const auto& [label, volume] : before) {
    const auto found = after.find(label);
    changes.push_back({label, volume, found == after.end() ? 0 : found->second});
  }
  return changes;
}

/// A line on the label whose volume has changed most; empty if none has by much.
std::string note_on_volumes(const std::vector<LabelChange>& changes) {
  constexpr double kMuchPercent = 0.1;
  const auto worst = std::ranges::max_element(
      changes, [](const auto& a, const auto& b) { return std::abs(a.percent()) < std::abs(b.percent()); });
  if (worst == changes.end() || std::abs(worst->percent()) <= kMuchPercent) return "";
  return fmt::format("label {} fills {:.2g} % {} than before: {:.6g} mm³, not {:.6g}", worst->label,
                     std::abs(worst->percent()), worst->percent() < 0 ? "less" : "more", worst->after_mm3,
                     worst->before_mm3);
}

/// A line where the surface needs far more vertices than a small complexity has; else empty.
std::string note_on_many_vertices(std::size_t vertices, const AdaptReport& report) {
  constexpr double kMany = 6;  // Per unit of complexity.
  if (!report.complete || static_cast<double>(vertices) < kMany * report.complexity) return "";
  return fmt::format(
      "{} vertices for a complexity of {:.3g}, of which about 2 each are usual: the surface needs more than "
      "the sizes ask for",
      vertices, report.complexity);
}

AdaptResult adapt_along_boundary(TetMesh& mesh, AdaptTarget& target, const AdaptRequest& request,
                                 Context& context) {
  const AdaptedBoundary boundary(mesh, request.boundary, context);
  AdaptOptions options = request.adapt;
  options.keep_within = boundary.keep_within();
  AdaptResult result{.report = target.complexity > 0
                                   ? adapt_to_complexity(mesh, target.field, boundary.shapes(),
                                                         target.complexity, options, context)
                                   : adapt(mesh, target.field, boundary.shapes(), options, context),
                     .patches_on_image = boundary.patches_on_image()};
  boundary.restore_patches(mesh);
  result.volumes = changes_of(result.report.volumes_before_mm3, volumes_of_labels(mesh));
  constexpr double kSeenMm = 1e-6;
  const std::string remedy =
      fmt::format("a smaller {} or {} may help", option_name("gradation"), option_name("max_size"));
  for (std::string note :
       {note_on_vertices_outside(mesh.points(), options.keep_within, kSeenMm, remedy),
        note_on_volumes(result.volumes), note_on_many_vertices(mesh.vertex_count(), result.report)})
    if (!note.empty()) result.notes.push_back(std::move(note));
  return result;
}

}  // namespace

AdaptTarget target_of_metric(const TetMesh& mesh, const metric::MetricLimits& limits, Context& context) {
  const double seen = metric::complexity(mesh);
  const bool is_met = metric::unmet_complexity(seen, limits).empty();
  return {context.phase("background", [&] { return metric::background_field(mesh, mesh.view().metric, 0); }),
          is_met ? limits.complexity : 0, seen};
}

AdaptResult adapt_mesh(TetMesh& mesh, const std::string& name, AdaptTarget target,
                       const AdaptRequest& request, Context& context) {
  naming(name, [&] {
    require_one_piece(mesh, request);
    check_fits_memory(target.complexity > 0 ? target.complexity : target.seen);
  });
  return naming(request.boundary.image ? request.image_name : name,
                [&] { return adapt_along_boundary(mesh, target, request, context); });
}

}  // namespace lumesh
