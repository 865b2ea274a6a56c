#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct AdaptCommand {
  std::string output_path, metric_output_path, json_path;
  MeshAdaptationRequest request;
  RunOptions run;
};

void run(AdaptCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  MeshAdaptationRequest& request = command.request;
  std::string &output_path = command.output_path, &metric_path = command.metric_output_path;
  request.validate();
  check_format(output_path, FileUse::kWriteVolume);
  check_format(metric_path, FileUse::kMetricAlone);
  check_output_folders({output_path, metric_path, command.json_path});
  check_inputs_stay({metric_path, command.json_path}, {request.mesh, request.tensors.file, request.image});
  request.stage.adapt.team.threads = threads_of(command.run);
  const AdaptedMesh made = adapt_mesh(request, command.run.making(), context);
  const AdaptReport& report = made.result.report;
  long_run.begin_writing({&output_path, &command.json_path, &metric_path}, report.complete);
  const MeshView mesh = made.mesh.view(), before = made.mesh.input().view();
  context.phase("write", [&] {
    write_mesh(output_path, mesh);
    if (!metric_path.empty()) write_metric(metric_path, mesh.metric);
  });
  warn_of_sealed_pieces(mesh, context);
  write_json(
      command.run, command.json_path,
      report::adapt_json(made, session.notes({{output_path, kMeshWords}, {metric_path, "its metric"}})));
  print_counts(command.run, report.by_thread);
  say(command.run, "{}", report::adapt_text(output_path, made, session.seconds()));
  long_run.require_sound(output_path, mesh, context, report.complete, &before);
}

}  // namespace

void add_adapt_command(CLI::App& program) {
  const auto command = std::make_shared<AdaptCommand>();
  CLI::App* sub = program.add_subcommand("adapt", "Adapt a tetrahedral mesh to a metric");
  MeshAdaptationRequest& request = command->request;
  add_mesh_argument(*sub, request.mesh);
  add_mesh_output(*sub, command->output_path);
  sub->add_option("--metric-output", command->metric_output_path,
                  with_formats("Write the adapted metric beside meshes without", FileUse::kMetricAlone));
  OptionList metric;
  request.describe_metric(metric);
  add_options(*sub, metric);
  add_keep_option(*sub, request.keep);
  add_image_option(*sub, request.image,
                   ": the surface follows its boundary instead of the mesh's own surface");
  add_options(*sub, options_of(request.selection), "", {"all_frames"});
  add_options_of(*sub, request.cuts);
  add_options_of(*sub, request.stage);
  add_topology_option(*sub, request.stage.adapt.team);
  add_json_option(*sub, command->json_path, command->run, "times and counts of operators");
  finish_command(*sub, command, "Example: lumesh adapt cube_metric.vtu -o adapted.vtu --complexity 100000");
}

}  // namespace lumesh::cli
