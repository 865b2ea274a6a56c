#include <fmt/core.h>

#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/improve_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct ImproveCommand {
  std::string mesh_path, output_path, json_path;
  ImproveRequest request;
  RunOptions run;
};

void say_cut(const RunOptions& run, const CutMesh& cut) {
  if (cut.openings.empty()) say(run, "cut: openings beside the plane moved into it\n");
  for (const CutMesh::Opening& opening : cut.openings)
    say(run, "cut: {} of {:.4g} mm² at {}\n", opening.name, opening.area_mm2, place_text(opening.centre_mm));
}

void run(ImproveCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  ImproveRequest& request = command.request;
  request.validate();
  check_volume_output(command.output_path);
  check_output_folders({command.output_path, command.json_path});
  check_inputs_stay({command.json_path}, {command.mesh_path, request.metric});
  request.options.team.threads = threads_of(command.run);
  MixedMesh input = context.phase("read", [&] { return read_mesh(command.mesh_path); });
  ImprovedMesh made = improve_mesh(input, command.mesh_path, request, context);
  const ImproveReport& report = made.report;
  if (!request.cut_planes.empty()) say_cut(command.run, made.cut);
  made.finish(provenance_of(*command.run.command, command.mesh_path, input.info.provenance), request,
              context);
  long_run.begin_writing({&command.output_path, &command.json_path}, report.complete);
  context.phase("write", [&] { write_mesh(command.output_path, made.view()); });
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_json(command.json_path, report::improve_json(report, request.options, made.cut, elapsed.count()));
  print_counts(command.run, report.by_thread);
  say(command.run,
      "{}: {} tetrahedra, dihedral angles {:.2f} to {:.2f} degrees (before: {:.2f} to {:.2f}), {} tetrahedra "
      "outside the targets (before: {}); {:.2f} s\n",
      command.output_path, made.mesh.changing().tet_count(), report.after.min_deg, report.after.max_deg,
      report.before.min_deg, report.before.max_deg, report.after.tets_outside, report.before.tets_outside,
      elapsed.count());
  const MeshView before = input.view();
  // A mesh that was cut is not the one that was given.
  require_sound(command.output_path, made.view(), context, long_run.reason(report.complete),
                request.cut_planes.empty() ? &before : nullptr);
  long_run.check_complete(report.complete, command.output_path + " holds the best mesh so far");
}

}  // namespace

void add_improve_command(CLI::App& program) {
  const auto command = std::make_shared<ImproveCommand>();
  CLI::App* sub = program.add_subcommand("improve", "Raise the worst dihedral angles of a tetrahedral mesh");
  add_mesh_argument(*sub, command->mesh_path);
  add_mesh_output(*sub, command->output_path);
  ImproveRequest& request = command->request;
  sub->add_option(
      "-m,--metric", request.metric,
      "Sizes that edges are to keep to (.sol, .solb), the same in all directions; default: the mesh's own");
  sub->add_flag("--ignore-sizes", request.ignores_sizes, "Leave out the metric that the mesh carries")
      ->excludes("--metric");
  OptionList cuts;
  describe_planes(cuts, request.cut_planes);
  add_options(*sub, cuts);
  add_options_of(*sub, request.options);
  add_topology_option(*sub, request.options.team);
  add_keep_option(*sub, request.keep)->excludes("--metric");
  add_json_option(*sub, command->json_path, command->run, "angles and counts of operators per pass");
  finish_command(*sub, command, "Example: lumesh improve case1.vtu -o improved.vtu");
}

}  // namespace lumesh::cli
