#pragma once
/// @file What commands that may run for minutes share: a time limit, Ctrl-C, progress.

#include <limits>
#include <string>

#include "common.hpp"
#include "lumesh/parallel/stopper.hpp"

namespace lumesh::cli {

/// --time-limit in seconds.
void add_time_limit_option(CLI::App& command, double& limit_s);

/// While it lives, the context is cancelled when the time is up or on Ctrl-C, and a terminal shows how much
/// of the work is done. Make it before the first parallel work.
class LongRun {
 public:
  LongRun(Context& context, const RunOptions& options, double limit_s);

  /// Why a run is not complete, for the beginning of a line; empty if it is.
  [[nodiscard]] std::string reason(bool complete) const;
  /// @throws Error{kTimeLimit} if the run was told to stop; `what_is_left` says what the user has now.
  void check_complete(bool complete, const std::string& what_is_left) const;

 private:
  double limit_s_;
  parallel::Stopper stopper_;
};

}  // namespace lumesh::cli
