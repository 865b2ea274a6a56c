#pragma once
/// @file What a running stage gets from its caller: messages, progress, phase times, cancellation.

#include <algorithm>
#include <chrono>
#include <exception>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace lumesh {

/// One timed step of a stage.
struct PhaseTime {
  std::string name;
  double seconds = 0;
};

/// Handed down through every stage.
///
/// Threads: a Context belongs to the thread that calls the stage, on which all sinks are called, one at a
/// time; cancelled() and stop_token() may be asked by any thread. Copies share the token, not the phases.
///
/// Progress: estimated shares of the work of one stage, which begins at 0 and ends at 1; in between they
/// never fall. Stages of few loops report none; phases tell where they are.
///
/// Cancellation: ask for a stop through the token's source, from any thread. Two kinds of work answer it.
///
/// adapt(), adapt_to_complexity(), improve() and mesh_delaunay() have a valid mesh before they are done, and
/// mesh_lattice() has one while it makes another for the sake of openings. They say so by results_exist(),
/// ask cancelled() from then on, put the mesh in order and return it as incomplete: about 0.3 s for 100,000
/// tetrahedra. run_case() writes it.
///
/// All else, and those five before, ends in parallel::Cancelled within parallel::run_cancellable()
/// (parallel/cancellation.hpp): at the next loop or block of one, usually a thousand elements or a slice.
/// Arguments that were being changed are good for their destructors only; files appear complete or not at
/// all. Without run_cancellable() it runs to its end.
///
/// `benchmarks/cases/stops.py` measures how long that takes; docs/measurements.md has the figures.
class Context {
 public:
  using MessageSink = std::function<void(std::string_view)>;
  using PhaseBeginSink = std::function<void(std::string_view name)>;
  using PhaseSink = std::function<void(const PhaseTime&)>;

  Context() = default;
  Context(MessageSink on_info, MessageSink on_warning, std::stop_token stop = {})
      : on_info_(std::move(on_info)), on_warning_(std::move(on_warning)), stop_(std::move(stop)) {}

  void info(std::string_view message) const {
    if (on_info_) on_info_(message);
  }
  void warn(std::string_view message) const {
    if (on_warning_) on_warning_(message);
  }
  void report_info_to(MessageSink sink) { on_info_ = std::move(sink); }
  /// Has `sink` called at the beginning of each phase, before phases within it.
  void report_phase_begins_to(PhaseBeginSink sink) { on_phase_begin_ = std::move(sink); }
  /// Has `sink` called at the end of each phase that does not throw; `sink` must not throw either.
  void report_phases_to(PhaseSink sink) { on_phase_ = std::move(sink); }
  /// Has `sink` called with the share of the stage's work that is done.
  void report_progress_to(std::function<void(double)> sink) { on_progress_ = std::move(sink); }
  /// By stages; 0 begins one.
  void progress(double share) {
    progress_ = share > 0 ? std::max(progress_, share) : 0;
    if (on_progress_) on_progress_(progress_);
  }
  /// Has `sink` called when there is a result that a stop must not lose.
  void report_results_to(std::function<void()> sink) { on_results_ = std::move(sink); }
  void results_exist() const {
    if (on_results_) on_results_();
  }
  void stop_by(std::stop_token stop) { stop_ = std::move(stop); }
  [[nodiscard]] bool cancelled() const { return stop_.stop_requested(); }
  [[nodiscard]] const std::stop_token& stop_token() const { return stop_; }

  /// Runs `step`, records its wall time under `name`, reports it, and returns what it returns.
  template <class Step>
  decltype(auto) phase(std::string name, Step&& step) {
    struct Recorder {
      Context& context;
      std::string name;
      int exceptions = std::uncaught_exceptions();
      std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
      ~Recorder() {
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
        context.phases_.push_back({std::move(name), elapsed.count()});
        const bool failed = std::uncaught_exceptions() > exceptions;
        if (context.on_phase_ && !failed) context.on_phase_(context.phases_.back());
      }
    } recorder{*this, std::move(name)};
    if (on_phase_begin_) on_phase_begin_(recorder.name);
    return std::forward<Step>(step)();
  }

  [[nodiscard]] const std::vector<PhaseTime>& phases() const { return phases_; }

 private:
  MessageSink on_info_;
  MessageSink on_warning_;
  PhaseBeginSink on_phase_begin_;
  PhaseSink on_phase_;
  std::function<void(double)> on_progress_;
  std::function<void()> on_results_;
  std::stop_token stop_;
  double progress_ = 0;
  std::vector<PhaseTime> phases_;
};

}  // namespace lumesh
