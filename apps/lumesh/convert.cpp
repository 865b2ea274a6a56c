#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct ConvertCommand {
  ConversionRequest request;
  std::string json_path;
  RunOptions run;
};

void run(const ConvertCommand& command) {
  const ConversionRequest& request = command.request;
  const MeshOutput& output = request.output;
  if (output.mesh.empty())
    throw Error(ErrorKind::kUsage,
                "no name for the mesh to write; give it as in: lumesh convert case1.vtu case1.msh");
  check_format(output.surface, FileUse::kWriteSurface);
  check_output_folders({output.mesh, output.surface, command.json_path});
  check_inputs_stay({output.surface, command.json_path}, {request.from});
  if (!request.only_labels.empty()) check_inputs_stay({output.mesh}, {request.from});
  CommandRun session(command.run);
  const MixedMesh mesh = convert_mesh(request, session.context);
  write_json(command.run, command.json_path, report::conversion_json(mesh, session.notes(files_of(output))));
  say(command.run, "{}", report::conversion_text(output, mesh));
}

}  // namespace

void add_convert_command(CLI::App& program) {
  const auto command = std::make_shared<ConvertCommand>();
  ConversionRequest& request = command->request;
  MeshOutput& output = request.output;
  CLI::App* sub = program.add_subcommand("convert", "Convert a mesh between file formats");
  add_mesh_argument(*sub, request.from, "from", FileUse::kRead);
  sub->add_option("to,-o,--output", output.mesh,
                  with_formats(kMeshToWrite, FileUse::kWrite) + ", as second name or with -o");
  add_options_of(*sub, request);
  add_json_option(*sub, command->json_path, command->run, "counts and patches");
  finish_command(*sub, command, "Example: lumesh convert case1.vtu case1.msh --msh-version 2.2", false);
}

}  // namespace lumesh::cli
