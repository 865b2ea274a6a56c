#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/report/file_description.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct InfoCommand {
  report::DescriptionRequest request;
  std::string json_path;
  RunOptions run;
};

void run(const InfoCommand& command) {
  const report::DescriptionRequest& request = command.request;
  request.cuts.validate();
  check_files({command.json_path}, {request.path}, request.selection);
  CommandRun session(command.run);
  const report::FileDescription description = report::describe_file(request, session.context);
  session.context.results_exist();
  const CLI::App& names = *command.run.command;
  write_json(command.run, command.json_path, with_flags(description.json, names));
  say(command.run, "{}", with_flags(description.text, names));
}

}  // namespace

void add_info_command(CLI::App& program) {
  const auto command = std::make_shared<InfoCommand>();
  report::DescriptionRequest& request = command->request;
  CLI::App* sub = program.add_subcommand("info", "Say what an image or a mesh holds");
  sub->add_option("file", request.path, with_formats("Image", FileUse::kReadImage) + " or mesh")->required();
  add_options(*sub, options_of(request.selection), "", {"all_frames"});
  add_unit_option(*sub, request.selection.unit);
  add_options_of(*sub, request.cuts);
  add_json_option(*sub, command->json_path, command->run, "the same");
  finish_command(*sub, command, "Example: lumesh info case1.nrrd");
}

}  // namespace lumesh::cli
