#include "long_run.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "lumesh/core/error.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

namespace {

/// One line that is written again and again, and at last removed.
void print_progress(double share, double elapsed_s) {
  if (share >= 1) {
    print_error("\r{:50}\r", "");
  } else {
    print_error("\r{:<50}", fmt::format("lumesh: {:.0f} % done, about {:.0f} s left", 100 * share,
                                        elapsed_s / share - elapsed_s));
  }
  std::fflush(stderr);
}

/// Files that were being written: OutputFile names them TARGET.part-PROCESS-NUMBER.
void remove_unfinished_files() {
  namespace fs = std::filesystem;
  const std::string mark = fmt::format(".part-{}-", ::getpid());
  std::error_code failed;
  fs::directory_iterator open("/proc/self/fd", failed);
  for (; !failed && open != fs::directory_iterator(); open.increment(failed)) {
    std::error_code ignored;
    const fs::path file = fs::read_symlink(open->path(), ignored);
    if (!ignored && file.filename().string().find(mark) != std::string::npos) fs::remove(file, ignored);
  }
}

[[noreturn]] void end_with(std::string_view what_is_left) {
  print_error("lumesh: error: interrupted; {}\n", what_is_left);
  std::fflush(stderr);
  remove_unfinished_files();
  std::_Exit(static_cast<int>(ErrorKind::kTimeLimit));
}

[[noreturn]] void give_up(bool /*finishes*/) {
  end_with("no unfinished file is left");
}

/// While results are being written, the mesh may be there by now.
[[noreturn]] void give_up_long_run(bool writes) {
  if (writes) give_up(writes);
  end_with("no mesh was written, and no unfinished file is left");
}

/// The path, or one beside another result that is there already.
std::string partial_path(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path target(path);
  const bool is_case = target.extension() == ".foam";  // Its mesh is the folder constant/polyMesh beside it.
  const fs::path result = is_case ? target.parent_path() / "constant" / "polyMesh" : target;
  const bool is_folder = fs::is_directory(result);
  if (!is_folder && !fs::is_regular_file(result)) return path;
  for (int number = 1;; ++number) {
    const std::string word = number == 1 ? "partial" : fmt::format("partial-{}", number);
    const std::string beside =
        is_folder ? word : fmt::format("{}.{}{}", target.stem().string(), word, target.extension().string());
    const fs::path free = target.parent_path() / beside;
    if (fs::exists(free)) continue;
    if (!is_folder) return free.string();
    fs::create_directories(free);
    return (free / target.filename()).string();
  }
}

}  // namespace

Interruptible::Interruptible() : cancellation_({.patience_s = 0, .give_up = give_up}) {}

void add_time_limit_option(CLI::App& command, double& limit_s) {
  OptionList list;
  list.number("time_limit", limit_s, above(0), "Stop then, write the best mesh so far and exit with 4")
      .in("s")
      .zero("none", std::numeric_limits<double>::infinity());
  add_options(command, list);
}

LongRun::LongRun(Context& context, const RunOptions& options, double limit_s)
    : limit_s_(limit_s), cancellation_({.limit_s = limit_s, .patience_s = 0.8, .give_up = give_up_long_run}) {
  context.stop_by(cancellation_.token());
  context.report_results_to([this] { cancellation_.finish(); });
  if (options.quiet > 0 || options.verbose > 0 || ::isatty(STDERR_FILENO) == 0) return;
  context.report_progress_to([start = std::chrono::steady_clock::now()](double share) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (share > 0) print_progress(share, elapsed.count());
  });
}

void LongRun::begin_writing(std::initializer_list<std::string*> paths, bool complete) {
  cancellation_.finish();
  if (complete) return;
  for (std::string* path : paths) *path = partial_path(*path);
}

std::string LongRun::reason(bool complete) const {
  if (complete) return "";
  const bool interrupted = cancellation_.reason() == parallel::CancellationSource::Reason::kSignal;
  return interrupted ? "interrupted; " : fmt::format("time limit of {} s reached; ", limit_s_);
}

void LongRun::check_complete(bool complete, const std::string& what_is_left) const {
  if (!complete) throw Error(ErrorKind::kTimeLimit, reason(complete) + what_is_left);
}

}  // namespace lumesh::cli
