#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "long_run.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/pipeline/pipeline.hpp"

namespace lumesh::cli {

namespace {

struct RunCommand {
  std::string case_path, folder;
  std::vector<std::string> settings;
  bool only_predicts = false, resumes = false, keeps_checkpoints = false;
  RunOptions run;
};

/// The case, with what the command line says about how it is run.
Case case_of(const RunCommand& command) {
  Case c = read_case(command.case_path, command.settings);
  if (!command.folder.empty())
    c.output.folder = std::filesystem::absolute(command.folder).lexically_normal().string();
  if (command.run.command->get_option("--threads")->count() > 0) c.run.threads = command.run.threads;
  if (std::isfinite(command.run.time_limit_s)) c.run.time_limit_s = command.run.time_limit_s;
  c.run.checkpoints = c.run.checkpoints || command.keeps_checkpoints || command.resumes;
  return c;
}

void print_prediction(const RunOptions& run, const CasePrediction& prediction) {
  for (const CasePrediction::Step& step : prediction.steps) {
    const std::string time = step.seconds > 0 ? fmt::format("about {:>7.1f} s", step.seconds) : "";
    const std::string size =
        step.tetrahedra > 0 ? fmt::format(", about {:.3g} tetrahedra", step.tetrahedra) : "";
    say(run, "{:<16} {}{}\n", time, step.what, size);
  }
  say(run, "about {:.3g} s in all, {:.2g} GB of memory of {:.3g} GB that are free; nothing was made\n",
      prediction.seconds(), prediction.peak_memory_bytes / 1e9,
      static_cast<double>(prediction.free_memory_bytes) / 1e9);
}

void require_good(const CaseResult& result, const std::string& besides) {
  if (!result.faults.empty())
    throw Error(ErrorKind::kNotReached, fmt::format("{}{}: the mesh is invalid: {}; do not use it", besides,
                                                    result.folder, fmt::join(result.faults, "; ")));
  const std::optional<report::LayersOfMesh>& layers = result.report.stages.back().layers;
  const std::string shortfall = layers ? layers->report.shortfall() : "";
  if (!shortfall.empty())
    throw Error(ErrorKind::kNotReached, fmt::format("{}{}: {}", besides, result.folder, shortfall));
  if (!result.without_name.empty())
    throw Error(ErrorKind::kNotReached,
                fmt::format("{}{}: {}", besides, result.folder, result.without_name.front()));
}

void run(const RunCommand& command, const Case& c) {
  RunOptions options = command.run;
  options.threads = c.run.threads;
  if (c.run.time_limit_s > 0) options.time_limit_s = c.run.time_limit_s;
  CommandRun session(options);
  Context& context = session.context;
  context.report_info_to([&](std::string_view line) {
    say(command.run, "{}\n", line);
    std::fflush(stdout);  // Pipes see each stage when it is done, too.
  });
  if (command.only_predicts) return print_prediction(command.run, predict_case(c, context));
  const LongRun long_run(options);
  const CaseResult result = run_case(c, command.resumes, context);
  say(command.run, "{}: {} in {:.1f} s, {:.2g} GB at the peak\n", result.folder, c.name,
      result.report.seconds, static_cast<double>(result.report.peak_memory_bytes) / 1e9);
  require_good(result, long_run.reason(result.complete));
  long_run.check_complete(result.complete, result.folder + " holds the best mesh so far");
}

/// Each frame, where all are wanted, has a folder of its own in that of the case.
void run(const RunCommand& command) {
  const Case c = case_of(command);
  if (!c.input.selection.all_frames) return run(command, c);
  const std::size_t count = count_frames(c.input.image);
  const std::filesystem::path folder =
      c.output.folder.empty() ? std::filesystem::absolute(c.name) : std::filesystem::path(c.output.folder);
  for (std::size_t frame = 0; frame < count; ++frame) {
    Case one = c;
    one.input.selection.all_frames = false;
    one.input.selection.frame = static_cast<double>(frame);
    one.output.folder = (folder / fmt::format("frame_{:03}", frame)).string();
    if (!command.only_predicts) std::filesystem::create_directories(folder);
    run(command, one);
  }
}

}  // namespace

void add_run_command(CLI::App& program) {
  const auto command = std::make_shared<RunCommand>();
  CLI::App* sub =
      program.add_subcommand("run", "Run a whole case: from the image to the adapted mesh and its report");
  sub->add_option("case", command->case_path, "Case file (.toml)")->required();
  sub->add_option("-o,--output", command->folder, "Folder for all files; default: the case's name");
  sub->add_option("--set", command->settings, "SECTION.KEY=VALUE, such as metric.k=30; may be repeated")
      ->allow_extra_args(false);
  CLI::Option* const dry = sub->add_flag(
      "--dry-run", command->only_predicts,
      "Say what would be done, and about how many elements, how long and how much memory it takes");
  sub->add_flag("--checkpoints", command->keeps_checkpoints, "Keep what every stage leaves, for --resume");
  sub->add_flag("--resume", command->resumes,
                "Take stages from checkpoints whose input and settings are the same; keeps checkpoints, too")
      ->excludes(dry);
  finish_command(*sub, command, "Example: lumesh run examples/case1_carotid.toml -o case1");
}

}  // namespace lumesh::cli
