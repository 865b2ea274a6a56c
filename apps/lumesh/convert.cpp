#include <fmt/core.h>

#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/input.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct ConvertCommand {
  std::string from, to, surface, compat, msh_version = "4.1", unit, out_unit;
  std::vector<std::string> only_labels;
  RunOptions run;
};

MeshWriteOptions write_options(const ConvertCommand& command) {
  MeshWriteOptions options;
  if (command.compat == "gmsh") options.compat = LabelAlias::kGmsh;
  if (command.compat == "medit") options.compat = LabelAlias::kMedit;
  if (command.compat == "simvascular") options.compat = LabelAlias::kSimVascular;
  options.msh_version = command.msh_version == "2.2" ? MshVersion::k22 : MshVersion::k41;
  return options;
}

void run(const ConvertCommand& command) {
  if (command.to.empty())
    throw Error(ErrorKind::kUsage,
                "no name for the mesh to write; give it as in: lumesh convert case1.vtu case1.msh");
  check_surface_output(command.surface);
  check_output_folders({command.to, command.surface});
  check_inputs_stay({command.surface}, {command.from});
  CommandRun session(command.run);
  Context& context = session.context;
  MixedMesh mesh = context.phase("read", [&] { return read_mesh_in(command.from, command.unit); });
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
  if (!command.only_labels.empty()) {
    check_inputs_stay({command.to}, {command.from});
    mesh = context.phase("labels", [&] {
      return naming(command.from,
                    [&] { return part_of(mesh, labels_called(mesh, command.only_labels)).mesh; });
    });
  }
  const MeshWriteOptions options = write_options(command);
  context.phase("write", [&] {
    const MeshInUnit written(mesh.view(), command.out_unit.empty() ? mesh.info.unit : command.out_unit);
    write_mesh(command.to, written.view(), options);
    if (!command.surface.empty()) write_surface(command.surface, written.view(), options);
  });
  if (mesh.view().cell_count() > 0) warn_of_faults(command.from, mesh.view());
  say(command.run, "{}: {} cells, {} points, {} boundary faces, {} patches\n", command.to,
      mesh.view().cell_count(), mesh.points.size(), mesh.triangles.size() + mesh.quadrilaterals.size(),
      mesh.info.patches.size());
}

}  // namespace

void add_convert_command(CLI::App& program) {
  const auto command = std::make_shared<ConvertCommand>();
  CLI::App* sub = program.add_subcommand("convert", "Convert a mesh between file formats");
  sub->add_option("from", command->from, "Mesh to read (" + formats_for(MeshUse::kRead) + ")")->required();
  sub->add_option("to,-o,--output", command->to,
                  "Mesh to write (" + formats_for(MeshUse::kWrite) + "), as second name or with -o");
  sub->add_option(
         "--only-labels", command->only_labels,
         "Take the cells of these labels only, by names or numbers; what lay between them and others "
         "is on the outside then")
      ->delimiter(',')
      ->allow_extra_args(false);
  sub->add_option("--surface", command->surface,
                  "Also write the boundary alone (" + formats_for(MeshUse::kWriteSurface) + ")");
  sub->add_option("--msh-version", command->msh_version, "Gmsh format")
      ->check(CLI::IsMember({"4.1", "2.2"}))
      ->capture_default_str();
  sub->add_option("--compat", command->compat, "Also name the label array as this program does")
      ->check(CLI::IsMember({"gmsh", "medit", "simvascular"}));
  add_unit_option(*sub, command->unit);
  sub->add_option("--out-unit", command->out_unit, "Unit of lengths in what is written; default: as they are")
      ->check(CLI::IsMember({"mm", "cm", "m", "um"}));
  finish_command(*sub, command, "Example: lumesh convert case1.vtu case1.msh --msh-version 2.2", false);
}

}  // namespace lumesh::cli
