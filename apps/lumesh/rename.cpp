#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"

namespace lumesh::cli {

namespace {

struct RenameCommand {
  RenamingRequest request;
  std::string json_path;
  RunOptions run;
};

void run(const RenameCommand& command) {
  const RenamingRequest& request = command.request;
  check_output_folders({request.to, command.json_path});
  check_inputs_stay({command.json_path}, {request.from});
  CommandRun session(command.run);
  const RenamedMesh made = rename_mesh(request, session.context);
  write_json(command.run, command.json_path,
             report::renaming_json(made, session.notes(files_of({.mesh = request.to}))));
  say(command.run, "{}", report::renaming_text(request.to, made));
}

}  // namespace

void add_rename_command(CLI::App& program) {
  const auto command = std::make_shared<RenameCommand>();
  CLI::App* sub = program.add_subcommand("rename", "Give patches of a mesh other names and kinds");
  add_mesh_argument(*sub, command->request.from, "from");
  add_mesh_output(*sub, command->request.to);
  add_name_option(*sub, command->request.names);
  sub->get_option("--name")->required();
  add_json_option(*sub, command->json_path, command->run, "what was renamed, and all patches");
  finish_command(
      *sub, command,
      "Example: lumesh rename case1.vtu -o named.vtu --name inlet_1=aorta:inlet --name 12.5,40,-3=left_ica",
      false);
}

}  // namespace lumesh::cli
