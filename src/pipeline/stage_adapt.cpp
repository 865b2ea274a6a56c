#include <fmt/core.h>

#include "lumesh/adapt/estimate.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/metric/background_field.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

void add_passes(const AdaptReport& report, report::StageReport& stage) {
  stage.figures.push_back({"Passes", std::uint64_t{report.passes.size()}});
  using operators::OperatorId;
  const operators::OperatorCounts counts = report.by_thread.of_all_threads();
  stage.figures.push_back({"Points put in", counts[OperatorId::kInsertion].applied});
  stage.figures.push_back({"Edges collapsed", counts[OperatorId::kCollapse].applied});
  stage.figures.push_back(
      {"Swaps", counts[OperatorId::kEdgeRemoval].applied + counts[OperatorId::kFaceRemoval].applied});
  stage.figures.push_back({"Vertices moved", counts[OperatorId::kSmoothing].applied});
}

}  // namespace

void adapt_mesh(CaseState& state, report::StageReport& stage) {
  stage.what =
      "Edges are split, collapsed, swapped and vertices moved until all edges have about unit length in the "
      "metric.";
  const metric::MetricLimits limits = limits_of(state.c);
  const double given = metric::complexity(state.mesh);
  // Where bounds on sizes keep the metric from the complexity asked for, scaling it would break them.
  const double wanted = metric::unmet_complexity(given, limits).empty() ? limits.complexity : 0;
  check_fits_memory(given);
  AdaptRequest request = state.c.adapt;
  request.adapt.team.threads = state.threads();
  if (!request.boundary.is_frozen && state.given.image)
    request.boundary.image = state.given.domain_of_image();
  naming(state.given.name, [&] { require_one_piece(state.mesh, request); });
  metric::MetricField field = state.context.phase(
      "background", [&] { return metric::background_field(state.mesh, state.mesh.view().metric, 0); });
  const AdaptResult adapted = naming(state.given.name, [&] {
    return lumesh::adapt_mesh(state.mesh, field, request, wanted, state.context);
  });
  const AdaptReport& report = adapted.report;
  stage.warnings.insert(stage.warnings.end(), adapted.notes.begin(), adapted.notes.end());
  state.is_complete = state.is_complete && report.complete;
  stage.figures.push_back({"Complexity", report.complexity, "", "as the adapted mesh sees it"});
  add_passes(report, stage);
  for (const LabelChange& label : adapted.volumes)
    stage.figures.push_back({fmt::format("Volume of label {}", label.label), label.after_mm3, "mm3",
                             fmt::format("{:+.3f} % of {:.6g} before", label.percent(), label.before_mm3)});
}

}  // namespace lumesh::pipeline
