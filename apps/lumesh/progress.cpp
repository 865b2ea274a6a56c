#include "progress.hpp"

#include <unistd.h>

#include <algorithm>

#include "common.hpp"
#include "usual_shares.hpp"

namespace lumesh::cli {

namespace {

using Seconds = std::chrono::duration<double>;

/// Rows of the command, in order.
std::span<const UsualShare> rows_of(std::string_view command) {
  const auto is_of = [&](const UsualShare& row) { return row.command == command; };
  const auto* const first = std::find_if(std::begin(kUsualShares), std::end(kUsualShares), is_of);
  return {first, std::find_if_not(first, std::end(kUsualShares), is_of)};
}

}  // namespace

void Progress::begin(std::string_view command, bool is_shown, Context& context) {
  state_.with([&](State& state) {
    state = {};
    state.is_shown = is_shown;
    state.command = command;
    state.start = state.row_start = Clock::now();
    constexpr std::chrono::seconds kQuiet(1);
    state.next_line = state.start + kQuiet;
  });
  if (!is_shown) return;
  context.report_phase_begins_to(
      [this](std::string_view name) { state_.with([&](State& state) { state.begin_phase(name); }); });
  context.report_phases_to(
      [this](const PhaseTime& phase) { state_.with([&](State& state) { state.end_phase(phase.name); }); });
  context.report_progress_to(
      [this](double share) { state_.with([&](State& state) { state.said = std::max(state.said, share); }); });
}

void Progress::State::begin_phase(std::string_view name) {
  phase = name;
  const std::span<const UsualShare> rows = rows_of(command);
  for (std::size_t next = row; next < rows.size(); ++next) {
    if (rows[next].phase != name) continue;
    for (; row < next; ++row) done += rows[row].percent / 100;
    said = 0;
    row_start = Clock::now();
    return;
  }
}

void Progress::State::end_phase(std::string_view name) {
  const std::span<const UsualShare> rows = rows_of(command);
  if (row == rows.size() || rows[row].phase != name) return;
  done += rows[row++].percent / 100;
  said = 0;
  row_start = Clock::now();
}

double Progress::State::share_at(Clock::time_point now) const {
  constexpr double kAlmost = 0.95, kKnown = 0.02;
  const std::span<const UsualShare> rows = rows_of(command);
  if (row == rows.size()) return done;
  double within = said;
  if (within == 0 && done > kKnown) {
    const double expected_s = Seconds(row_start - start).count() * rows[row].percent / 100 / done;
    within = std::min(kAlmost, Seconds(now - row_start).count() / expected_s);
  }
  return std::max(share, done + within * rows[row].percent / 100);
}

double seconds_left(double seconds_so_far, double share) {
  // Shares add up to one only within rounding, and -0 prints as such.
  return share < 1 ? seconds_so_far * (1 / share - 1) : 0;
}

void Progress::State::write(bool is_terminal) {
  constexpr double kWorthATime = 0.05, kNearlyAll = 0.97;
  constexpr auto kAgain = std::chrono::milliseconds(200);
  constexpr auto kNextLine = std::chrono::seconds(30);
  const Clock::time_point now = Clock::now();
  if (!is_shown || now < (is_terminal ? next_line : start + kNextLine) || now < next_line) return;
  next_line = now + (is_terminal ? std::chrono::milliseconds(kAgain) : std::chrono::milliseconds(kNextLine));
  share = share_at(now);
  std::string text = fmt::format("lumesh: {}", phase);
  // Behind the last usual phases nobody knows how much comes: a case may have layers, or not.
  const bool is_known = share < kNearlyAll;
  if (is_known && share > 0) text += fmt::format(", {:.0f} %", 100 * share);
  if (is_known && share > kWorthATime)
    text += fmt::format(", about {:.0f} s left", seconds_left(Seconds(now - start).count(), share));
  else
    text += fmt::format(", {:.0f} s so far", Seconds(now - start).count());
  // The cursor waits at the beginning: whatever is printed next takes the line's place.
  print_error("{}{}", text, is_terminal ? "\r" : "\n");
  std::fflush(stderr);
}

void Progress::tick() {
  const bool is_terminal = ::isatty(STDERR_FILENO) != 0;
  state_.with([&](State& state) { state.write(is_terminal); });
}

void Progress::end() {
  state_.with([](State& state) {
    if (state.is_shown && state.share > 0) print_error("");
    state.is_shown = false;
  });
}

}  // namespace lumesh::cli
