#pragma once
/// @file A source of cancellation for long work: its time limit, and signals to the program.

#include <atomic>
#include <csignal>
#include <functional>
#include <limits>
#include <stop_token>
#include <thread>

namespace lumesh::parallel {

/// Watches the clock and the signals SIGINT, SIGTERM and SIGHUP, but those that are ignored (nohup), and
/// requests a stop through its token. One at a time; make it before other threads start, so that signals come
/// here.
class CancellationSource {
 public:
  enum class Reason { kNone, kTime, kSignal };

  struct Options {
    double limit_s = std::numeric_limits<double>::infinity();
    /// After a signal the work may take so long to end in good order, unless finish() was called; then, and
    /// at a second signal, `give_up` is called by the watching thread.
    double patience_s = std::numeric_limits<double>::infinity();
    /// Ends the program; empty: exit code 4 without a word. Told whether finish() was called.
    std::function<void(bool finishes)> give_up = {};
  };

  explicit CancellationSource(Options options);
  /// Signals do again what they did before.
  ~CancellationSource();
  CancellationSource(const CancellationSource&) = delete;
  CancellationSource& operator=(const CancellationSource&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  [[nodiscard]] Reason reason() const { return reason_.load(); }
  /// Only results are left to be written: that may take its time.
  void finish() { finishes_.store(true); }

 private:
  void watch(const std::stop_token& over);
  void stop(Reason reason);
  void give_up() const;

  Options options_;
  sigset_t signals_;
  std::stop_source source_;
  std::atomic<Reason> reason_ = Reason::kNone;
  std::atomic<bool> finishes_ = false;
  std::jthread watcher_;
};

}  // namespace lumesh::parallel
