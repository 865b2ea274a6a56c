#pragma once
/// @file Ends long work in good order when its time is up or the user interrupts the program.

#include <atomic>
#include <limits>
#include <stop_token>
#include <thread>

namespace lumesh::parallel {

/// Watches the clock and the signals SIGINT and SIGTERM, and asks whoever holds the token to stop. A second
/// signal ends the program at once. One at a time; make it before other threads start, so that signals come
/// here.
class Stopper {
 public:
  enum class Reason { kNone, kTime, kSignal };

  explicit Stopper(double limit_s = std::numeric_limits<double>::infinity());
  /// Signals do again what they did before.
  ~Stopper();
  Stopper(const Stopper&) = delete;
  Stopper& operator=(const Stopper&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  [[nodiscard]] Reason reason() const { return reason_.load(); }

 private:
  void watch(double limit_s, const std::stop_token& over);
  void stop(Reason reason);

  std::stop_source source_;
  std::atomic<Reason> reason_ = Reason::kNone;
  std::jthread watcher_;
};

}  // namespace lumesh::parallel
