#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "frames.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct DelaunayCommand : FirstMeshCommand<DelaunayFileRequest> {};

void run(DelaunayCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  auto& [input, openings, mesher] = command.request;
  MeshOutput& output = command.output;
  mesher.validate();
  check_domain_options(*command.run.command, input);
  check_format(output.mesh, FileUse::kWriteVolume);
  check_format(output.surface, FileUse::kWriteSurface);
  check_files(
      {output.mesh, output.surface, command.json_path},
      {input.path, mesher.sizes.points, mesher.sizes.image, mesher.sizes.mesh, mesher.sizes.plugin_path()},
      input.selection);
  mesher.improvement.team.threads = threads_of(command.run);
  DelaunayFileMesh made = make_delaunay_mesh(command.request, command.run.making(), context);
  const bool is_complete = made.made.is_complete;
  long_run.begin_writing({&output.mesh, &output.surface, &command.json_path}, is_complete);
  write_mesh(output, made.view(), context);
  const FirstMeshComparison compared = compare_with_input(made, context);
  write_json(command.run, command.json_path,
             report::delaunay_json(made, compared, session.notes(files_of(output))));
  say(command.run, "{}",
      report::delaunay_text(output.mesh, made, compared.openings, context, session.seconds()));
  long_run.require_sound(output.mesh, made.made.mesh.view(made.faces), context, is_complete);
  openings.require(output.mesh, compared.openings, made.input.without_name);
}

}  // namespace

void add_delaunay_command(CLI::App& program) {
  const auto command = std::make_shared<DelaunayCommand>();
  DelaunayFileRequest& request = command->request;
  CLI::App* sub = program.add_subcommand(
      "delaunay", "Mesh a segmented image, or the inside of a surface, by Delaunay refinement");
  add_mesh_output(*sub, command->output.mesh);
  add_options_of(*sub, request.mesher);
  ImproveOptions& improvement = request.mesher.improvement;
  OptionList beside;
  describe_cells_per_diameter(beside, request.mesher.sizes.cells_per_diameter);
  describe_execution(beside, improvement.execution, improvement.team);
  add_options(*sub, beside);
  add_topology_option(*sub, improvement.team);
  add_surface_output(*sub, command->output.surface);
  add_json_option(*sub, command->json_path, command->run, "times, rounds and angles");
  add_domain_options(*sub, request.input);
  add_out_unit_option(*sub, command->output.unit);
  add_opening_options(*sub, request.openings);
  finish_command(
      *sub, command, [](const DelaunayCommand& c) { run_frames(c); },
      "Example: lumesh delaunay case1.nrrd -o case1.vtu --edge-length 1.5");
}

}  // namespace lumesh::cli
