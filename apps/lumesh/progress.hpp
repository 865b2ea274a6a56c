#pragma once
/// @file How far a command is: one line on a terminal that is written again and again, else a line now and
/// then.

#include <chrono>
#include <string>
#include <string_view>

#include "lumesh/core/context.hpp"
#include "lumesh/parallel/guarded.hpp"

namespace lumesh::cli {

/// How long the rest takes, if it goes on like what was done; never negative. @param share  Above 0.
[[nodiscard]] double seconds_left(double seconds_so_far, double share);

/// Goes by the usual shares of a command's phases (usual_shares.hpp), within a phase by what the stage says
/// or by the time that phases took so far; never falls. tick() may be called by another thread.
class Progress {
 public:
  /// A command begins; hears of its phases from now on.
  /// @param is_shown  False: nothing is written.
  void begin(std::string_view command, bool is_shown, Context& context);
  /// Writes, if it is time to.
  void tick();
  /// Clears the line.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  struct State {
    bool is_shown = false;
    std::string command, phase;
    std::size_t row = 0;  ///< Of the usual shares: the phase that runs, or the next.
    double done = 0;      ///< Shares of the rows before.
    double said = 0;      ///< By the stage, of the row.
    double share = 0;     ///< Of all, as last written.
    Clock::time_point start, row_start, next_line;

    void begin_phase(std::string_view name);
    void end_phase(std::string_view name);
    void write(bool is_terminal);

   private:
    [[nodiscard]] double share_at(Clock::time_point now) const;
  };

  parallel::Guarded<State> state_;
};

}  // namespace lumesh::cli
