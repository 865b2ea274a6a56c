#include <fmt/core.h>

#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh::cli {

namespace {

struct RenameCommand {
  std::string from, to;
  std::vector<std::string> names;
  RunOptions run;
};

void run(const RenameCommand& command) {
  check_output_folders({command.to});
  CommandRun session(command.run);
  Context& context = session.context;
  MixedMesh mesh = context.phase("read", [&] { return read_mesh(command.from); });
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
  const std::vector<PatchRenaming> renamings = naming(
      command.from, [&] { return with_patches(renamings_from(command.names), named_openings(mesh.view())); });
  naming(command.from, [&] { rename_patches(mesh.info, renamings); });
  context.phase("write", [&] { write_mesh(command.to, mesh.view()); });
  warn_of_faults(command.from, mesh.view());
  for (const PatchRenaming& renaming : renamings)
    say(command.run, "{}: {} is {}{} now\n", command.to, renaming.patch, renaming.name,
        renaming.kind ? fmt::format(", kind {},", renaming.kind->word()) : "");
}

}  // namespace

void add_rename_command(CLI::App& program) {
  const auto command = std::make_shared<RenameCommand>();
  CLI::App* sub = program.add_subcommand("rename", "Give patches of a mesh other names and kinds");
  add_mesh_argument(*sub, command->from, "from");
  add_mesh_output(*sub, command->to);
  add_name_option(*sub, command->names);
  sub->get_option("--name")->required();
  finish_command(
      *sub, command,
      "Example: lumesh rename case1.vtu -o named.vtu --name inlet_1=aorta:inlet --name 12.5,40,-3=left_ica",
      false);
}

}  // namespace lumesh::cli
