#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "keep_option.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct ImproveCommand {
  std::string output_path, json_path;
  ImproveRequest request;
  RunOptions run;
};

void run(ImproveCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  ImproveRequest& request = command.request;
  request.validate();
  check_format(command.output_path, FileUse::kWriteVolume);
  check_output_folders({command.output_path, command.json_path});
  check_inputs_stay({command.json_path}, {request.mesh, request.metric});
  request.options.team.threads = threads_of(command.run);
  const ImprovedMesh made = improve_mesh(request, command.run.making(), context);
  const bool is_complete = made.report.complete;
  long_run.begin_writing({&command.output_path, &command.json_path}, is_complete);
  context.phase("write", [&] { write_mesh(command.output_path, made.view()); });
  warn_of_sealed_pieces(made.view(), context);
  write_json(command.run, command.json_path,
             report::improve_json(made, request.options, session.notes({{command.output_path, kMeshWords}})));
  print_counts(command.run, made.report.by_thread);
  say(command.run, "{}", report::improve_text(command.output_path, made, request, session.seconds()));
  const MeshView before = made.mesh.input().view();
  // A mesh that was cut is not the one that was given.
  long_run.require_sound(command.output_path, made.view(), context, is_complete,
                         request.cut_planes.empty() ? &before : nullptr);
}

}  // namespace

void add_improve_command(CLI::App& program) {
  const auto command = std::make_shared<ImproveCommand>();
  CLI::App* sub = program.add_subcommand("improve", "Raise the worst dihedral angles of a tetrahedral mesh");
  ImproveRequest& request = command->request;
  add_mesh_argument(*sub, request.mesh);
  add_mesh_output(*sub, command->output_path);
  sub->add_option("-m,--metric", request.metric,
                  with_formats("Sizes that edges are to keep to", FileUse::kMetricAlone) +
                      ", the same in all directions; default: the mesh's own");
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
