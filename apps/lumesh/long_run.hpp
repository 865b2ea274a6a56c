#pragma once
/// @file What commands share that take their time: Ctrl-C, a time limit, progress.

#include <limits>
#include <string>

#include "common.hpp"
#include "lumesh/parallel/cancellation_source.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::cli {

/// --time-limit in seconds.
void add_time_limit_option(CLI::App& command, double& limit_s);

/// Ends the program within a second of the first Ctrl-C or SIGTERM, with exit code 4 and a line; nothing of
/// files that were being written is left. Make it before the first parallel work.
class Interruptible {
 public:
  Interruptible();

 private:
  parallel::CancellationSource cancellation_;
};

/// What a command runs in, made before anything else; long ones have a LongRun.
struct CommandRun {
  Interruptible interruptible;
  parallel::ThreadLimit limit;
  Context context;

  explicit CommandRun(const RunOptions& options) : limit(options.threads), context(make_context(options)) {}
};

/// While it lives, the context is cancelled when the time is up or on Ctrl-C, and a terminal shows how much
/// of the work is done. Work that does not end in good order within a second of Ctrl-C, and has not begun to
/// write results, ends as in Interruptible. Make it before the first parallel work.
class LongRun {
 public:
  LongRun(Context& context, const RunOptions& options, double limit_s);
  LongRun(const LongRun&) = delete;
  LongRun& operator=(const LongRun&) = delete;

  /// From now on results are written: each path stays, but becomes one beside it if the run is not complete
  /// and another result is there already.
  void begin_writing(std::initializer_list<std::string*> paths, bool complete);

  /// Why a run is not complete, for the beginning of a line; empty if it is.
  [[nodiscard]] std::string reason(bool complete) const;
  /// @throws Error{kTimeLimit} if the run was told to stop; `what_is_left` says what the user has now.
  void check_complete(bool complete, const std::string& what_is_left) const;

 private:
  double limit_s_;
  parallel::CancellationSource cancellation_;
};

}  // namespace lumesh::cli
