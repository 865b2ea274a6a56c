#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct MetricCommand {
  std::string mesh_path, output_path, json_path;
  MeshMetricRequest request;
  RunOptions run;
};

void run(const MetricCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  const std::string &mesh_path = command.mesh_path, &output_path = command.output_path;
  check_output_folders({output_path, command.json_path});
  check_inputs_stay({command.json_path}, {mesh_path, command.request.image});
  const bool alone = is_metric_file(output_path);
  if (!alone && !is_for(output_path, FileUse::kCarryMetric))
    throw Error(ErrorKind::kUsage,
                fmt::format("{}: only {}, {} files carry a metric", output_path,
                            formats_for(FileUse::kCarryMetric), formats_for(FileUse::kMetricAlone, " and ")));
  command.request.validate();
  MixedMesh input = context.phase("read", [&] { return read_mesh(mesh_path); });
  MeshWithMetric made = give_metric(input, mesh_path, command.request, context);
  made.mesh.finish_metric(provenance_of(command.run.making(), mesh_path, input.info.provenance));
  write_results(context, [&] {
    if (alone)
      write_metric(output_path, made.mesh.view().metric);
    else
      write_mesh(output_path, made.mesh.view());
  });
  if (!made.result.unmet.empty()) context.warn(made.result.unmet);
  write_json(command.json_path,
             report::metric_json(
                 made, session.notes({{output_path, alone ? "the metric" : "the mesh with its metric"}})));
  say(command.run, "{}: metric of {} vertices, complexity {:.4g} on this mesh\n", output_path,
      made.mesh.changing().vertex_count(), made.result.complexity);
}

}  // namespace

void add_metric_command(CLI::App& program) {
  const auto command = std::make_shared<MetricCommand>();
  CLI::App* sub = program.add_subcommand("metric", "Give every vertex of a mesh a metric tensor");
  add_mesh_argument(*sub, command->mesh_path);
  sub->add_option("-o,--output", command->output_path,
                  with_formats("Mesh with the metric to write", FileUse::kCarryMetric) +
                      with_formats(", or the metric alone", FileUse::kMetricAlone))
      ->required();
  MeshMetricRequest& request = command->request;
  add_options_of(*sub, request.metric);
  sub->add_option("--image", request.image,
                  "Label image the mesh was made of, whose boundary's curvature is taken instead")
      ->needs("--curvature");
  const OptionList of_image = options_of(request.selection);
  add_options(*sub, of_image, "", {"all_frames"});
  for (const Option& option : of_image.all())
    if (CLI::Option* const flag = sub->get_option_no_throw(flag_of(option.name))) flag->needs("--image");
  // Their rows are those of all points.
  add_keep_option(*sub, request.keep)->excludes("--metric")->excludes("--hessian");
  add_json_option(*sub, command->json_path, command->run, "counts, complexity and times");
  finish_command(
      *sub, command,
      "Example: lumesh metric vessel.vtu --points centerline.vtp --gradation 1.3 --complexity 180000 -o "
      "vessel_metric.vtu");
}

}  // namespace lumesh::cli
