#pragma once
/// @file What a running stage gets from its caller: messages, progress, phase times, cancellation.

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

/// Handed down through every stage. Not thread-safe, except cancelled(), which any thread may call.
class Context {
 public:
  using MessageSink = std::function<void(std::string_view)>;
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
  /// Has `sink` called at the end of each phase that does not throw; `sink` must not throw either.
  void report_phases_to(PhaseSink sink) { on_phase_ = std::move(sink); }
  /// Has `sink` called with the share of the work that is done, estimated, from 0 to 1.
  void report_progress_to(std::function<void(double)> sink) { on_progress_ = std::move(sink); }
  void progress(double share) const {
    if (on_progress_) on_progress_(share);
  }
  /// Has `sink` called when all that is left is to write results, which must not be lost.
  void report_results_to(std::function<void()> sink) { on_results_ = std::move(sink); }
  void results_follow() const {
    if (on_results_) on_results_();
  }
  void stop_by(std::stop_token stop) { stop_ = std::move(stop); }
  [[nodiscard]] bool cancelled() const { return stop_.stop_requested(); }

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
    return std::forward<Step>(step)();
  }

  [[nodiscard]] const std::vector<PhaseTime>& phases() const { return phases_; }

 private:
  MessageSink on_info_;
  MessageSink on_warning_;
  PhaseSink on_phase_;
  std::function<void(double)> on_progress_;
  std::function<void()> on_results_;
  std::stop_token stop_;
  std::vector<PhaseTime> phases_;
};

}  // namespace lumesh
