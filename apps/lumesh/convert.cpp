#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"

namespace lumesh::cli {

namespace {

struct ConvertCommand {
  ConversionRequest request;
  std::string json_path, compat, msh_version = "4.1";
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

void run(ConvertCommand command) {
  const ConversionRequest& request = command.request;
  const MeshOutput& output = request.output;
  command.request.output.options = write_options(command);
  if (output.mesh.empty())
    throw Error(ErrorKind::kUsage,
                "no name for the mesh to write; give it as in: lumesh convert case1.vtu case1.msh");
  check_surface_output(output.surface);
  check_output_folders({output.mesh, output.surface, command.json_path});
  check_inputs_stay({output.surface, command.json_path}, {request.from});
  if (!request.only_labels.empty()) check_inputs_stay({output.mesh}, {request.from});
  CommandRun session(command.run);
  const MixedMesh mesh = convert_mesh(request, session.context);
  write_json(command.json_path, report::conversion_json(mesh, session.notes(files_of(output))));
  say(command.run, "{}", report::conversion_text(output.mesh, mesh));
}

}  // namespace

void add_convert_command(CLI::App& program) {
  const auto command = std::make_shared<ConvertCommand>();
  ConversionRequest& request = command->request;
  MeshOutput& output = request.output;
  output.unit = "";  // As it is.
  CLI::App* sub = program.add_subcommand("convert", "Convert a mesh between file formats");
  sub->add_option("from", request.from, "Mesh to read (" + formats_for(MeshUse::kRead) + ")")->required();
  sub->add_option("to,-o,--output", output.mesh,
                  "Mesh to write (" + formats_for(MeshUse::kWrite) + "), as second name or with -o");
  sub->add_option(
         "--only-labels", request.only_labels,
         "Take the cells of these labels only, by names or numbers; what lay between them and others "
         "is on the outside then")
      ->delimiter(',')
      ->allow_extra_args(false);
  sub->add_option("--surface", output.surface,
                  "Also write the boundary alone (" + formats_for(MeshUse::kWriteSurface) + ")");
  sub->add_option("--msh-version", command->msh_version, "Gmsh format")
      ->check(CLI::IsMember({"4.1", "2.2"}))
      ->capture_default_str();
  sub->add_option("--compat", command->compat, "Also name the label array as this program does")
      ->check(CLI::IsMember({"gmsh", "medit", "simvascular"}));
  add_unit_option(*sub, request.unit);
  sub->add_option("--out-unit", output.unit, "Unit of lengths in what is written; default: as they are")
      ->check(CLI::IsMember({"mm", "cm", "m", "um"}));
  add_json_option(*sub, command->json_path, command->run, "counts and patches");
  finish_command(*sub, command, "Example: lumesh convert case1.vtu case1.msh --msh-version 2.2", false);
}

}  // namespace lumesh::cli
