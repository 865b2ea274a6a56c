#include "long_run.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "lumesh/core/error.hpp"

namespace lumesh::cli {

namespace {

/// One line that is written again and again, and at last removed.
void print_progress(double share, double elapsed_s) {
  if (share >= 1) {
    fmt::print(stderr, "\r{:50}\r", "");
  } else {
    fmt::print(stderr, "\r{:<50}",
               fmt::format("lumesh: {:.0f} % done, about {:.0f} s left", 100 * share,
                           elapsed_s / share - elapsed_s));
  }
  std::fflush(stderr);
}

}  // namespace

void add_time_limit_option(CLI::App& command, double& limit_s) {
  command
      .add_option("--time-limit", limit_s,
                  "Stop after so many seconds, write the best mesh so far and exit with 4")
      ->check(positive_number());
}

LongRun::LongRun(Context& context, const RunOptions& options, double limit_s)
    : limit_s_(limit_s), stopper_(limit_s) {
  context.stop_by(stopper_.token());
  if (options.quiet > 0 || options.verbose > 0 || ::isatty(STDERR_FILENO) == 0) return;
  context.report_progress_to([start = std::chrono::steady_clock::now()](double share) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (share > 0) print_progress(share, elapsed.count());
  });
}

std::string LongRun::reason(bool complete) const {
  if (complete) return "";
  const bool interrupted = stopper_.reason() == parallel::Stopper::Reason::kSignal;
  return interrupted ? "interrupted; " : fmt::format("time limit of {} s reached; ", limit_s_);
}

void LongRun::check_complete(bool complete, const std::string& what_is_left) const {
  if (!complete) throw Error(ErrorKind::kTimeLimit, reason(complete) + what_is_left);
}

}  // namespace lumesh::cli
