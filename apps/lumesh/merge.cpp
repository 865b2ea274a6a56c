#include <algorithm>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct MergeCommand {
  std::vector<std::string> paths;
  std::string output_path, json_path;
  MergeOptions options;
  RunOptions run;
};

void check_names(const MergeCommand& command) {
  check_format(command.output_path, FileUse::kWriteVolume);
  check_output_folders({command.output_path, command.json_path});
  check_inputs_stay({command.output_path}, command.paths);
  if (command.paths.size() < 2)
    throw Error(ErrorKind::kUsage, "one mesh alone cannot be merged; name two or more");
  for (const std::string& path : command.paths)
    if (std::ranges::count(command.paths, path) > 1)
      throw Error(ErrorKind::kUsage, path + ": is named twice; a mesh cannot be merged with itself");
  check_inputs_stay({command.json_path}, command.paths);
}

void run(MergeCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_names(command);
  MergedFiles merged = merge_files(command.paths, command.options, context);
  MixedMesh& mesh = merged.result.mesh;
  mesh.info.provenance = provenance_of(command.run.making(), command.paths.front(), merged.provenance);
  const std::string problems = context.phase("check", [&] { return problems_of(mesh); });
  if (!problems.empty()) context.warn(command.output_path + ": " + problems);
  write_results(context, [&] { write_mesh(command.output_path, mesh.view()); });
  warn_of_sealed_pieces(mesh.view(), context);
  write_json(command.run, command.json_path,
             report::merge_json(merged.result.report, command.paths,
                                session.notes({{command.output_path, kMeshWords}})));
  say(command.run, "{}", report::merge_text(command.output_path, merged.result, command.paths));
  require_sound(command.output_path, mesh.view(), context);
}

}  // namespace

void add_merge_command(CLI::App& program) {
  const auto command = std::make_shared<MergeCommand>();
  CLI::App* sub = program.add_subcommand("merge", "Join meshes that touch into one conforming mesh");
  sub->add_option("meshes", command->paths, with_formats("Two or more meshes to read", FileUse::kReadVolume))
      ->required();
  add_mesh_output(*sub, command->output_path);
  add_options_of(*sub, command->options);
  add_json_option(*sub, command->json_path, command->run, "what was joined");
  finish_command(*sub, command, "Example: lumesh merge lumen.vtu wall.vtu -o vessel.vtu");
}

}  // namespace lumesh::cli
