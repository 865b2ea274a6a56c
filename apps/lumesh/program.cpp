#include "program.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "common.hpp"
#include "exit_codes.hpp"

namespace lumesh::cli {

namespace {

namespace fs = std::filesystem;

/// The file, or the folder of files, that is being written and has `mark` in its name; empty if there is
/// none.
fs::path unfinished_part(const fs::path& file, const std::string& mark) {
  fs::path part;
  for (const fs::path& step : file) {
    part /= step;
    if (step.string().find(mark) != std::string::npos) return part;
  }
  return {};
}

/// Files that were being written: io names them, or their folder, TARGET.part-PROCESS-NUMBER.
void remove_unfinished_files() {
  const std::string mark = fmt::format(".part-{}-", ::getpid());
  std::error_code failed;
  fs::directory_iterator open("/proc/self/fd", failed);
  for (; !failed && open != fs::directory_iterator(); open.increment(failed)) {
    std::error_code ignored;
    const fs::path file = fs::read_symlink(open->path(), ignored);
    if (const fs::path part = unfinished_part(file, mark); !part.empty()) fs::remove_all(part, ignored);
  }
}

[[noreturn]] void give_up(const Program& program) {
  print_error("lumesh: error: {}\n", program.line_of_end());
  std::fflush(stderr);
  remove_unfinished_files();
  std::_Exit(exit_code_of(ErrorKind::kTimeLimit));
}

}  // namespace

Program::Program(std::string description, std::string name)
    : App(std::move(description), std::move(name)),
      cancellation_({.give_up = [this] { give_up(*this); },
                     .on_kept =
                         [this](parallel::CancellationSource::Reason reason) {
                           const bool by_signal = reason == parallel::CancellationSource::Reason::kSignal;
                           print_error("lumesh: {}what there is will be written{}\n", reason_of_stop(),
                                       by_signal ? "; once more ends it at once" : "");
                         },
                     .on_tick = [this] { progress_.tick(); }}) {}

std::string Program::reason_of_stop() const {
  return cancellation_.reason() == parallel::CancellationSource::Reason::kTime
             ? fmt::format("time limit of {} s reached; ", cancellation_.limit_s())
             : "interrupted; ";
}

Program& program_of(CLI::App& command) {
  return dynamic_cast<Program&>(*command.get_parent());
}

}  // namespace lumesh::cli
