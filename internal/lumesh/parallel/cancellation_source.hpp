#pragma once
/// @file A source of cancellation for a program: its time limit, and signals to it.

#include <atomic>
#include <csignal>
#include <functional>
#include <limits>
#include <mutex>
#include <stop_token>
#include <thread>

namespace lumesh::parallel {

/// Holds back the signals that a CancellationSource watches, until there is one, which takes them.
void hold_watched_signals();

/// Watches the clock and the signals SIGINT, SIGTERM and SIGHUP, but those that are ignored (nohup), and
/// requests a stop through its tokens. One at a time; make it before other threads start, so that signals
/// come here.
class CancellationSource {
 public:
  enum class Reason { kNone, kTime, kSignal };

  /// All are called by the watching thread.
  struct Options {
    /// Ends the program: what is to be abandoned has not ended `patience_s` after the stop, or a second
    /// signal has come.
    std::function<void()> give_up;
    double patience_s = 0.2;
    /// A stop was requested while there are results to keep, which work puts in order and writes; may be
    /// empty.
    std::function<void(Reason)> on_kept = {};
    /// Called about every 20 ms; may be empty.
    std::function<void()> on_tick = {};
  };

  explicit CancellationSource(Options options);
  /// Signals do again what they did before.
  ~CancellationSource();
  CancellationSource(const CancellationSource&) = delete;
  CancellationSource& operator=(const CancellationSource&) = delete;

  /// For a Context: any stop.
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  /// For run_cancellable(): a stop while there are no results to keep.
  [[nodiscard]] std::stop_token abandon_token() const { return abandon_.get_token(); }
  [[nodiscard]] Reason reason() const { return reason_.load(); }

  /// Other work begins: no results yet, and so long to go. A signal that came too late for the work before
  /// ends this one.
  void begin(double limit_s = std::numeric_limits<double>::infinity());
  [[nodiscard]] double limit_s() const { return limit_s_; }
  /// From now on there are results that a stop must not lose. @throws Cancelled if one came before.
  void keep_results();

 private:
  void watch(const std::stop_token& over);
  void stop(Reason reason);

  Options options_;
  sigset_t signals_;
  std::stop_source source_, abandon_;
  // A stop comes either before results are kept or after, for both sides.
  std::mutex deciding_;
  bool keeps_results_ = false;
  // Each stands for itself, so that their default order is more than enough. Written by the working thread,
  // read by the watching one, but reason_: the other way round. Tests: Cancellation* in
  // tests/unit/parallel/cancellation_test.cpp.
  std::atomic<Reason> reason_ = Reason::kNone;
  std::atomic<double> end_s_ = std::numeric_limits<double>::infinity();  // Of the limit, on the steady clock.
  double limit_s_ = std::numeric_limits<double>::infinity();             // The working thread's own.
  std::jthread watcher_;
};

}  // namespace lumesh::parallel
