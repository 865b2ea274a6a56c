#include <fmt/core.h>

#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/mesh_adaptation.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct AdaptCommand {
  std::string mesh_path, output_path, metric_output_path, json_path;
  MeshAdaptationRequest request;
  RunOptions run;
};

/// Refuses before anything is read what contradicts itself.
void check_options(const AdaptCommand& command) {
  const MeshAdaptationRequest& request = command.request;
  request.validate();
  check_volume_output(command.output_path);
  if (!command.metric_output_path.empty() && !is_metric_file(command.metric_output_path))
    throw Error(ErrorKind::kUsage, "--metric-output " + command.metric_output_path + ": must be " +
                                       formats_for(MeshUse::kMetricAlone, " or "));
  check_output_folders({command.output_path, command.metric_output_path, command.json_path});
  check_inputs_stay({command.metric_output_path, command.json_path},
                    {command.mesh_path, request.tensors.file, request.image});
}

void run(AdaptCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  check_options(command);
  command.request.stage.adapt.team.threads = threads_of(command.run);
  MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  AdaptedMesh made = adapt_mesh(input, command.mesh_path, command.request, context);
  const AdaptReport& report = made.result.report;
  made.mesh.finish(provenance_of(*command.run.command, command.mesh_path, input.info.provenance), context);
  long_run.begin_writing({&command.output_path, &command.json_path, &command.metric_output_path},
                         report.complete);
  const MeshView mesh = made.mesh.view();
  context.phase("write", [&] {
    write_mesh(command.output_path, mesh);
    if (!command.metric_output_path.empty()) write_metric(command.metric_output_path, mesh.metric);
  });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_json(command.json_path, report::adapt_json(made.result, context, elapsed.count()));
  print_counts(command.run, report.by_thread);
  say(command.run, "{}: {} tetrahedra, {} vertices, {} boundary triangles, complexity {:.0f}; {:.2f} s\n",
      command.output_path, made.mesh.changing().tet_count(), made.mesh.changing().vertex_count(),
      made.mesh.faces().triangles.size(), report.complexity, elapsed.count());
  if (made.mesh.has_kept()) say(command.run, "with {} cells as they were\n", made.mesh.kept_count());
  const MeshView before = input.view();
  require_sound(command.output_path, mesh, context, long_run.reason(report.complete), &before);
  long_run.check_complete(report.complete, command.output_path + " holds the best mesh so far");
}

}  // namespace

void add_adapt_command(CLI::App& program) {
  const auto command = std::make_shared<AdaptCommand>();
  CLI::App* sub = program.add_subcommand("adapt", "Adapt a tetrahedral mesh to a metric");
  add_mesh_argument(*sub, command->mesh_path);
  add_mesh_output(*sub, command->output_path);
  sub->add_option("--metric-output", command->metric_output_path,
                  "Write the metric of the adapted mesh (.sol, .solb) beside meshes that carry none");
  MeshAdaptationRequest& request = command->request;
  OptionList metric;
  request.describe_metric(metric);
  add_options(*sub, metric);
  add_keep_option(*sub, request.keep);
  sub->add_option("--image", request.image,
                  std::string("Image that the mesh was made of ") + kImageFormats +
                      ": the surface follows its boundary instead of the mesh's own surface");
  add_options_of(*sub, request.selection);
  add_options_of(*sub, request.cuts);
  add_options_of(*sub, request.stage);
  add_topology_option(*sub, request.stage.adapt.team);
  add_json_option(*sub, command->json_path, command->run, "times and counts of operators");
  finish_command(*sub, command, "Example: lumesh adapt cube_metric.vtu -o adapted.vtu --complexity 100000");
}

}  // namespace lumesh::cli
