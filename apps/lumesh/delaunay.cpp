#include <fmt/core.h>

#include <chrono>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "domain_input.hpp"
#include "frames.hpp"
#include "kernel_options.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct DelaunayCommand {
  std::string mesh_path, surface_path, json_path, out_unit = "mm";
  DomainInput input;
  OpeningRequest openings;
  DelaunayRequest request;
  RunOptions run;

  [[nodiscard]] FrameParts frames() {
    return {&input.selection, input.path, {&mesh_path, &surface_path, &json_path}};
  }
};

/// Refuses what contradicts itself before anything is read.
void check_options(DelaunayCommand& command) {
  command.request.validate();
  check_domain_options(*command.run.command, command.input);
  check_volume_output(command.mesh_path);
  check_surface_output(command.surface_path);
  const SizeRequest& sizes = command.request.sizes;
  check_files({command.mesh_path, command.surface_path, command.json_path},
              {command.input.path, sizes.points, sizes.image, sizes.mesh, sizes.plugin_path()},
              command.input.selection);
}

void print_summary(const DelaunayCommand& command, DomainRead& given, const DelaunayMesh& made,
                   const BoundaryFaces& faces, const OpeningsCompared& openings, const Context& context,
                   double seconds) {
  const TetMesh& mesh = made.mesh;
  const Domain& domain = given.domain();
  const std::optional<ImproveReport>& improved = made.improved;
  say(command.run, "{}: {} tetrahedra, {} vertices, {} boundary triangles\n", command.mesh_path,
      mesh.tet_count(), mesh.vertex_count(), faces.triangles.size());
  for (const std::string& line : closing_lines(given.closed())) say(command.run, "  {}\n", line);
  say(command.run, "{}", patch_lines(mesh.info(), faces.patches, openings));
  if (!domain.fixed_points().empty())
    say(command.run, "  {} of the surface's {} vertices are vertices of the mesh\n",
        made.report.fixed_points_kept, domain.fixed_points().size());
  if (improved)
    say(command.run, "  dihedral angles {:.2f} to {:.2f} degrees (before improvement: {:.2f} to {:.2f})\n",
        improved->after.min_deg, improved->after.max_deg, improved->before.min_deg, improved->before.max_deg);
  say(command.run, "{}", time_line(context, seconds));
}

void run(DelaunayCommand command) {
  const auto start = std::chrono::steady_clock::now();
  CommandRun session(command.run);
  Context& context = session.context;
  LongRun long_run(command.run);
  check_options(command);
  const std::string& input_path = command.input.path;
  SizeData sizes = context.phase("read", [&] { return SizeData(command.request.sizes, context); });
  DomainRead given = read_domain(command.input, context);
  const DomainRead::Survey survey = given.survey(command.request.sizes.needs_axes());
  given.drop_image();
  const Domain& domain = given.domain();
  const std::unique_ptr<Sizing> sizing = naming(input_path, [&] {
    return context.phase("sizes", [&] { return std::move(sizes).on(domain, survey.axes); });
  });
  command.request.improvement.team.threads = threads_of(command.run);
  const std::vector<PatchRenaming> renamings = renamings_for(command.openings, given.openings());
  DelaunayMesh made =
      naming(input_path, [&] { return make_delaunay_mesh(domain, command.request, sizing.get(), context); });
  TetMesh& mesh = made.mesh;
  mesh.info().provenance = provenance_of(*command.run.command, input_path);
  const std::vector<std::string> without_name = rename_found(mesh.info(), renamings);
  const BoundaryFaces faces = mesh.boundary_faces();
  const bool is_complete = made.is_complete;
  long_run.begin_writing({&command.mesh_path, &command.surface_path, &command.json_path}, is_complete);
  MeshView view = mesh.view(faces);
  view.metric = {};  // What improvement works with says nothing.
  write_with_surface(view, command.out_unit, command.mesh_path, command.surface_path, context);
  for (const std::string& note : made.report.notes) context.warn(note);
  if (!survey.closed_vessels.empty()) context.warn(survey.closed_vessels);
  const std::vector<std::string> others = given.differences_from(mesh);
  for (const std::string& line : others) context.warn(line);
  const OpeningsCompared openings = checked_openings(mesh.view(faces), domain, given.openings(), context);
  if (sizing)
    for (const std::string& warning : sizing->warnings()) context.warn(warning);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (!command.json_path.empty())
    write_json(command.json_path, report::delaunay_json(made, openings, given.closed(), others, context));
  print_summary(command, given, made, faces, openings, context, elapsed.count());
  require_sound(command.mesh_path, mesh.view(faces), context, long_run.reason(is_complete));
  long_run.check_complete(is_complete, command.mesh_path + " holds the best mesh so far");
  command.openings.require(command.mesh_path, openings, without_name);
}

}  // namespace

void add_delaunay_command(CLI::App& program) {
  const auto command = std::make_shared<DelaunayCommand>();
  CLI::App* sub = program.add_subcommand(
      "delaunay", "Mesh a segmented image, or the inside of a surface, by Delaunay refinement");
  add_mesh_output(*sub, command->mesh_path);
  add_options_of(*sub, command->request);
  OptionList cells, execution;
  describe_cells_per_diameter(cells, command->request.sizes.cells_per_diameter);
  add_options(*sub, cells);
  ImproveOptions& improvement = command->request.improvement;
  describe_execution(execution, improvement.execution, improvement.team);
  add_options(*sub, execution);
  add_topology_option(*sub, improvement.team);
  add_surface_output(*sub, command->surface_path);
  add_json_option(*sub, command->json_path, command->run, "times, rounds and angles");
  add_domain_options(*sub, command->input);
  add_out_unit_option(*sub, command->out_unit);
  add_opening_options(*sub, command->openings);
  finish_command(
      *sub, command, [](const DelaunayCommand& c) { run_frames(c); },
      "Example: lumesh delaunay case1.nrrd -o case1.vtu --edge-length 1.5");
}

}  // namespace lumesh::cli
