#pragma once
/// @file The program as a whole: what ends it early, and what tells how far it is.

#include <CLI/CLI.hpp>
#include <string>

#include "lumesh/parallel/cancellation_source.hpp"
#include "progress.hpp"

namespace lumesh::cli {

/// Make it before other threads start. Ctrl-C, SIGTERM and time limits end every command with exit code 4 and
/// a line: by an exception (parallel::Cancelled) where there is nothing to keep, or, where that takes longer
/// than a fifth of a second, and at a second signal, at once. Nothing of files that were being written is
/// left. A stop that comes once the command has said that it has results (Context::results_exist()), at the
/// latest before it writes the first, does not keep it from writing all of them.
class Program : public CLI::App {
 public:
  Program(std::string description, std::string name);

  [[nodiscard]] parallel::CancellationSource& cancellation() { return cancellation_; }
  [[nodiscard]] Progress& progress() { return progress_; }
  /// Why a command was told to stop, for the beginning of a line.
  [[nodiscard]] std::string reason_of_stop() const;
  /// Message printed when a run ends without a result.
  [[nodiscard]] std::string line_of_end() const { return reason_of_stop() + "no unfinished file is left"; }

 private:
  Progress progress_;
  parallel::CancellationSource cancellation_;
};

/// The program that a command is one of.
[[nodiscard]] Program& program_of(CLI::App& command);

}  // namespace lumesh::cli
