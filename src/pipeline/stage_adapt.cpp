#include <fmt/core.h>

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

void add_volumes(const std::vector<LabelChange>& labels, report::StageReport& stage) {
  for (const LabelChange& label : labels)
    stage.figures.push_back({fmt::format("Volume of label {}", label.label), label.after_mm3, "mm3",
                             fmt::format("{:+.3f} % of {:.6g} before", label.percent(), label.before_mm3)});
}

}  // namespace

void adapt_mesh(CaseState& state, report::StageReport& stage) {
  stage.what =
      "Edges are split, collapsed, swapped and vertices moved until all edges have about unit length in the "
      "metric.";
  AdaptRequest request = state.c.adapt;
  request.adapt.team.threads = state.threads();
  if (!request.boundary.is_frozen && state.given.image)
    request.boundary.image = state.given.domain_of_image();
  request.image_name = state.given.name;
  const AdaptResult adapted = lumesh::adapt_mesh(
      state.mesh, state.given.name, target_of_metric(state.mesh, limits_of(state.c), state.context), request,
      state.context);
  const AdaptReport& report = adapted.report;
  stage.warnings.insert(stage.warnings.end(), adapted.notes.begin(), adapted.notes.end());
  state.is_complete = state.is_complete && report.complete;
  stage.figures.push_back({"Complexity", report.complexity, "", "as the adapted mesh sees it"});
  add_passes(report, stage);
  add_volumes(adapted.volumes, stage);
}

}  // namespace lumesh::pipeline
