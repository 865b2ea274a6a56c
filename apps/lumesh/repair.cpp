#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_text.hpp"
#include "lumesh/stages/mesh_output.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct RepairCommand {
  std::string from, to, json_path;
  RepairRequest request;
  RunOptions run;
};

void run(RepairCommand command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_format(command.to, FileUse::kWriteSurface);
  check_files({command.to, command.json_path}, {command.from});
  command.request.in_single_precision = is_for(command.to, FileUse::kWriteSingle);
  RepairOutcome outcome = repair_file(command.from, command.request, context);
  std::map<std::string, std::string>& provenance = outcome.surface.info.provenance;
  provenance = provenance_of(command.run.making(), command.from, provenance);
  write_results(context, [&] { write_surface(command.to, outcome.surface.view()); });
  warn_of_names(command.to, outcome.surface.view(), context);
  write_json(command.run, command.json_path,
             report::repair_json(outcome, session.notes({{command.to, "the repaired surface"}})));
  say(command.run, "{}", report::repair_text(command.to, outcome));
}

}  // namespace

void add_repair_command(CLI::App& program) {
  const auto command = std::make_shared<RepairCommand>();
  CLI::App* sub = program.add_subcommand("repair", "Make a surface with faults one that can be meshed");
  sub->add_option("from", command->from, with_formats("Surface to read", FileUse::kRead))->required();
  sub->add_option("-o,--output", command->to, with_formats("Surface to write", FileUse::kWriteSurface))
      ->required();
  add_options_of(*sub, command->request);
  add_json_option(*sub, command->json_path, command->run, "what was done");
  finish_command(*sub, command, "Example: lumesh repair scanned.stl -o sound.vtp");
}

}  // namespace lumesh::cli
