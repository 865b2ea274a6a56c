#include "lumesh/lattice/lattice.hpp"

#include <fmt/core.h>

#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "frames.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct LatticeCommand {
  std::string mesh_path, surface_path, out_unit = "mm";
  DomainInput input;
  double cells_per_diameter = 0;
  OpeningRequest openings;
  LatticeOptions options;
  RunOptions run;

  [[nodiscard]] FrameParts frames() { return {&input.selection, input.path, {&mesh_path, &surface_path}}; }
};

void print_summary(const LatticeCommand& command, const LatticeResult& result,
                   const OpeningsCompared& openings, const Context& context, double seconds) {
  const MixedMesh& mesh = result.mesh;
  print_out("{}: {} tetrahedra, ", command.mesh_path, mesh.tetrahedra.size());
  if (command.options.mixed)
    print_out("{} hexahedra, {} pyramids, ", mesh.hexahedra.size(), mesh.pyramids.size());
  print_out("{} vertices, {} boundary triangles\n", mesh.points.size(), mesh.triangles.size());
  print_out("{}{}", patch_lines(mesh.info, mesh.triangle_patches, openings), time_line(context, seconds));
}

void run(const LatticeCommand& command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  const DomainInput& input = command.input;
  input.cuts.validate();
  check_surface_output(command.surface_path);
  check_files({command.mesh_path, command.surface_path}, {command.input.path}, command.input.selection);
  DomainRead given = read_domain(input, context);
  LatticeOptions options = command.options;
  if (command.cells_per_diameter > 0)
    options.fidelity = LatticeOptions::fidelity_of_cells(command.cells_per_diameter);
  // Before the time for a domain is spent.
  naming(input.path, [&] { options.require_labels_of(*given.image); });
  const DomainRead::Survey survey = given.survey(false);
  const ImageDomain& domain = *given.domain_of_image();
  const std::vector<PatchRenaming> renamings = renamings_for(command.openings, given.openings());
  LatticeResult result = mesh_lattice(*given.image, domain, options, context);
  const std::vector<std::string> without_name = rename_found(result.mesh.info, renamings);
  result.mesh.info.provenance = provenance_of(*command.run.command, input.path);
  write_with_surface(result.mesh.view(), command.out_unit, command.mesh_path, command.surface_path, context);
  for (const std::string& note : result.report.notes) context.warn(note);
  if (!survey.closed_vessels.empty()) context.warn(survey.closed_vessels);
  for (const std::string& line : given.differences_from_lattice(result.mesh.view())) context.warn(line);
  const OpeningsCompared compared = checked_openings(result.mesh.view(), domain, given.openings(), context);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (command.run.quiet == 0) print_summary(command, result, compared, context, elapsed.count());
  require_sound(command.mesh_path, result.mesh.view(), context);
  command.openings.require(command.mesh_path, compared, without_name);
}

}  // namespace

void add_lattice_command(CLI::App& program) {
  const auto command = std::make_shared<LatticeCommand>();
  CLI::App* sub = program.add_subcommand("lattice", "Mesh a segmented image on a body-centred cubic lattice");
  sub->add_option("image", command->input.path, std::string("Label image ") + kImageFormats)->required();
  add_mesh_output(*sub, command->mesh_path);
  add_surface_output(*sub, command->surface_path);
  add_options_of(*sub, command->options);
  OptionList cells;
  describe_cells_per_diameter(cells, command->cells_per_diameter);
  add_options(*sub, cells);
  sub->get_option("--cells-per-diameter")->excludes("--fidelity");
  add_options_of(*sub, command->input.selection);
  add_unit_option(*sub, command->input.selection.unit);
  add_out_unit_option(*sub, command->out_unit);
  add_options_of(*sub, command->input.cuts);
  add_options_of(*sub, command->input.field);
  add_opening_options(*sub, command->openings);
  finish_command(
      *sub, command, [](const LatticeCommand& c) { run_frames(c); },
      "Example: lumesh lattice case1.nrrd -o case1.vtu --spacing 1.2 --cut-plane 0 0 10 0 0 -1");
}

}  // namespace lumesh::cli
