#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "frames.hpp"
#include "long_run.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct LatticeCommand : FirstMeshCommand<LatticeRequest> {};

void run(LatticeCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  const auto& [input, openings, options, cells_per_diameter] = command.request;
  MeshOutput& output = command.output;
  input.cuts.validate();
  check_format(output.surface, FileUse::kWriteSurface);
  check_files({output.mesh, output.surface, command.json_path}, {input.path}, input.selection);
  LatticeMesh made = make_lattice_mesh(command.request, command.run.making(), context);
  const bool is_complete = made.made.report.complete;
  long_run.begin_writing({&output.mesh, &output.surface, &command.json_path}, is_complete);
  write_mesh(output, made.made.mesh.view(), context);
  const FirstMeshComparison compared = compare_with_input(made, context);
  write_json(command.run, command.json_path,
             report::lattice_json(made, compared, session.notes(files_of(output))));
  say(command.run, "{}",
      report::lattice_text(output.mesh, made, compared.openings, context, session.seconds()));
  long_run.require_sound(output.mesh, made.made.mesh.view(), context, is_complete);
  openings.require(output.mesh, compared.openings, made.input.without_name);
}

}  // namespace

void add_lattice_command(CLI::App& program) {
  const auto command = std::make_shared<LatticeCommand>();
  LatticeRequest& request = command->request;
  CLI::App* sub = program.add_subcommand("lattice", "Mesh a segmented image on a body-centred cubic lattice");
  sub->add_option("image", request.input.path, with_formats("Label image", FileUse::kReadImage))->required();
  add_mesh_output(*sub, command->output.mesh);
  add_surface_output(*sub, command->output.surface);
  add_json_option(*sub, command->json_path, command->run, "counts, openings, differences and times");
  add_options_of(*sub, request.options);
  OptionList cells;
  describe_cells_per_diameter(cells, request.cells_per_diameter);
  add_options(*sub, cells);
  sub->get_option("--cells-per-diameter")->excludes("--fidelity");
  add_options_of(*sub, request.input.selection);
  add_unit_option(*sub, request.input.selection.unit);
  add_out_unit_option(*sub, command->output.unit);
  add_options_of(*sub, request.input.cuts);
  add_options_of(*sub, request.input.field);
  add_opening_options(*sub, request.openings);
  finish_command(
      *sub, command, [](const LatticeCommand& c) { run_frames(c); },
      "Example: lumesh lattice case1.nrrd -o case1.vtu --spacing 1.2 --cut-plane 0 0 10 0 0 -1");
}

}  // namespace lumesh::cli
