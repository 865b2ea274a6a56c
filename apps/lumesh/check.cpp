#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/report/stage_json.hpp"
#include "lumesh/report/stage_pages.hpp"
#include "lumesh/report/stage_text.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

struct CheckCommand {
  std::string path;
  ImageSelection selection;
  std::string json_path, report_path;
  RunOptions run;
};

void run(const CheckCommand& command) {
  CommandRun session(command.run);
  Context& context = session.context;
  check_files({command.json_path, command.report_path}, {command.path}, command.selection);
  if (is_mesh_file(command.path)) {
    ImageSelection of_images = command.selection;
    require_not_given(*command.run.command, options_of(of_images),
                      fmt::format("is for images, and {} is none", command.path));
  }
  CheckReport report = check_file(command.path, command.selection, context);
  for (Finding& finding : report.findings)
    for (std::string* text : {&finding.text, &finding.remedy})
      *text = with_flags(*text, *command.run.command);
  context.results_exist();
  write_json(command.run, command.json_path, report::check_json(command.path, report));
  say(command.run, "{}", report::check_text(command.path, report));
  if (!command.report_path.empty())
    write_text_file(command.report_path, report::check_page(command.path, report, context));
  if (!report.is_fit())
    throw Error(ErrorKind::kNotReached,
                command.path + ": is unfit for meshing as it is; see the faults above");
}

}  // namespace

void add_check_command(CLI::App& program) {
  const auto command = std::make_shared<CheckCommand>();
  CLI::App* sub = program.add_subcommand(
      "check", "Find faults and thin places of a surface, a mesh or an image, with places and remedies");
  sub->add_option("file", command->path, with_formats("Surface, mesh or label image", FileUse::kReadImage))
      ->required();
  OptionList selection = options_of(command->selection);
  describe_unit(selection, command->selection.unit);
  add_options(*sub, selection, "", {"probabilities", "all_frames"});
  add_json_option(*sub, command->json_path, command->run, "the same");
  sub->add_option("--report", command->report_path, kReportHelp);
  finish_command(
      *sub, command,
      "Exit codes: 0 fit for meshing, perhaps with remarks, 2 unreadable, 3 unfit.\nExample: lumesh check "
      "vessel.stl");
}

}  // namespace lumesh::cli
