#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "frames.hpp"
#include "long_run.hpp"
#include "lumesh/pipeline/pipeline.hpp"

namespace lumesh::cli {
namespace {

struct RunCommand {
  std::string case_path, folder, json_path;
  std::vector<std::string> settings;
  bool only_predicts = false, resumes = false, keeps_checkpoints = false;
  RunOptions run;
};

/// The case, with what the command line says about how it is run.
Case case_of(const RunCommand& command) {
  Case c = read_case(command.case_path, command.settings);
  if (!command.folder.empty())
    c.output.folder = std::filesystem::absolute(command.folder).lexically_normal().string();
  const auto is_given = [&](const char* flag) { return command.run.command->get_option(flag)->count() > 0; };
  if (is_given("--threads")) c.run.threads = command.run.threads;
  if (is_given("--time-limit")) c.run.time_limit_s = command.run.time_limit_s;
  c.run.resumes = command.resumes;
  c.run.checkpoints = c.run.checkpoints || command.keeps_checkpoints || command.resumes;
  return c;
}

void run(const RunCommand& command, const Case& c, const std::string& json_path) {
  RunOptions options = command.run;
  options.threads = c.run.threads;
  options.time_limit_s = c.run.time_limit_s;
  options.with_keys = [&c](const std::string& message) { return c.with_keys(message); };
  CommandRun session(options);
  session.context.report_info_to([&](std::string_view line) { say_line(command.run, line); });
  if (command.only_predicts) return say(command.run, "{}", predict_case(c, session.context).text());
  const LongRun long_run(options);
  const CaseResult result = run_case(c, session.context);
  say(command.run, "{}", result.text());
  write_json(command.run, json_path, result.json());
  result.require_good(long_run.reason(result.complete));
  long_run.check_complete(result.complete, result.folder);
}

void run(const RunCommand& command) {
  check_files({command.json_path}, {command.case_path});
  const std::vector<Case> cases = cases_of_frames(case_of(command));
  if (cases.size() == 1) return run(command, cases.front(), command.json_path);
  JsonArray array;
  RunCommand one = command;
  one.run.json_array = &array;
  for (std::size_t i = 0; i < cases.size(); ++i) run(one, cases[i], numbered(command.json_path, i));
}
}  // namespace

void add_run_command(CLI::App& program) {
  const auto command = std::make_shared<RunCommand>();
  CLI::App* sub =
      program.add_subcommand("run", "Run a whole case: from the image to the adapted mesh and its report");
  sub->add_option("case", command->case_path, "Case file (.toml)")->required();
  sub->add_option("-o,--output", command->folder, meaning_of(OutputKeys(), "folder"));
  sub->add_option("--set", command->settings, "SECTION.KEY=VALUE, such as metric.k=30; may be repeated")
      ->allow_extra_args(false);
  CLI::Option* const dry = sub->add_flag(
      "--dry-run", command->only_predicts,
      "Say what would be done, and about how many elements, how long and how much memory it takes");
  sub->add_flag("--checkpoints", command->keeps_checkpoints, meaning_of(RunKeys(), "checkpoints"));
  sub->add_flag("--resume", command->resumes,
                "Take stages from checkpoints whose input and settings are the same; keeps checkpoints, too")
      ->excludes(dry);
  add_json_option(*sub, command->json_path, command->run, "the numbers of the case's report")->excludes(dry);
  finish_command(*sub, command, "Example: lumesh run examples/case1_carotid.toml -o case1");
}

}  // namespace lumesh::cli
