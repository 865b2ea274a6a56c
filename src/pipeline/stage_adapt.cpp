#include <fmt/core.h>

#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/boundary.hpp"
#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/pipeline/input.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

metric::MetricField field_on_copy(const TetMesh& mesh) {
  TetMesh background = TetMesh::build(mesh.points(), mesh.tets(), mesh.labels());
  metric::shape_metric(background, mesh.view().metric);
  return metric::MetricField::on_background(std::move(background));
}

AdaptedBoundary boundary_of(CaseState& state) {
  BoundaryOptions options{.is_frozen = state.c.boundary.boundary == BoundaryMode::kFrozen,
                          .feature_angle_deg = state.c.boundary.feature_angle_deg};
  if (!options.is_frozen && state.image) options.image = state.domain_of_image();
  return naming(state.input_name, [&] { return AdaptedBoundary(state.mesh, options, state.context); });
}

void add_passes(const AdaptReport& report, report::StageReport& stage) {
  stage.figures.push_back({"Passes", std::uint64_t{report.passes.size()}});
  const operators::OperatorCounts counts = report.by_thread.of_all_threads();
  stage.figures.push_back({"Points put in", counts.insertion.applied});
  stage.figures.push_back({"Edges collapsed", counts.collapse.applied});
  stage.figures.push_back({"Swaps", counts.edge_removal.applied + counts.face_removal.applied});
  stage.figures.push_back({"Vertices moved", counts.smoothing.applied});
}

}  // namespace

void adapt_mesh(CaseState& state, report::StageReport& stage) {
  stage.what =
      "Edges are split, collapsed, swapped and vertices moved until all edges have about unit length in the "
      "metric.";
  const double asked = state.c.metric.complexity, given = metric::complexity(state.mesh);
  // Where bounds on sizes keep the metric from the complexity asked for, scaling it would break them.
  const double wanted = metric::unmet_complexity(given, limits_of(state.c)).empty() ? asked : 0;
  check_fits_memory(given);
  if (!state.c.boundary.allows_pieces)
    naming(state.input_name, [&] {
      refuse_pieces(state.mesh, "[input] largest_component = true", "[adapt] allow_pieces = true");
    });
  metric::MetricField field = state.context.phase("background", [&] { return field_on_copy(state.mesh); });
  const AdaptedBoundary boundary = boundary_of(state);
  AdaptOptions options = state.c.adapt;
  options.team.threads = state.threads();
  options.keep_within = boundary.keep_within();
  const AdaptReport report =
      wanted > 0 ? adapt_to_complexity(state.mesh, field, boundary.shapes(), wanted, options, state.context)
                 : adapt(state.mesh, field, boundary.shapes(), options, state.context);
  boundary.restore_patches(state.mesh);
  state.is_complete = state.is_complete && report.complete;
  stage.figures.push_back({"Complexity", report.complexity, "", "as the adapted mesh sees it"});
  add_passes(report, stage);
}

}  // namespace lumesh::pipeline
