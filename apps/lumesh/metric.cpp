#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  std::string output_path, json_path;
  MeshMetricRequest request;
  RunOptions run;
};

void run(const MetricCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  const MeshMetricRequest& request = command.request;
  const std::string& output_path = command.output_path;
  request.validate();
  check_output_folders({output_path, command.json_path});
  check_inputs_stay({command.json_path}, {request.mesh, request.image});
  require_holds_metric(output_path);
  const MeshWithMetric made = give_metric(request, command.run.making(), context);
  write_with_metric(output_path, made.mesh.view(), context);
  const char* const words = is_metric_file(output_path) ? "the metric" : "the mesh with its metric";
  write_json(command.run, command.json_path,
             report::metric_json(made, session.notes({{output_path, words}})));
  say(command.run, "{}: metric of {} vertices, complexity {:.4g} on this mesh\n", output_path,
      made.mesh.changing().vertex_count(), made.result.complexity);
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  MeshMetricRequest& request = command->request;
  add_mesh_argument(*sub, request.mesh);
  sub->add_option("-o,--output", command->output_path,
                  with_formats("Mesh with the metric to write", FileUse::kCarryMetric) +
                      with_formats(", or the metric alone", FileUse::kMetricAlone))
      ->required();
  add_options_of(*sub, request.metric);
  add_image_option(*sub, request.image, ": the curvature is that of its boundary");
  add_options(*sub, options_of(request.selection), "", {"all_frames"});
  add_keep_option(*sub, request.keep);
  add_json_option(*sub, command->json_path, command->run, "counts, complexity and times");
  finish_command(
      *sub, command,
      "Example: lumesh metric vessel.vtu --points centerline.vtp --gradation 1.3 --complexity 180000 -o "
      "vessel_metric.vtu");
}

}  // namespace lumesh::cli
