#include "lumesh/parallel/cancellation_source.hpp"

#include <chrono>
#include <csignal>
#include <ctime>

#include "lumesh/parallel/cancellation.hpp"

namespace lumesh::parallel {
namespace {

constexpr int kWake =
    SIGURG;  // Of the watching thread; nobody else is told by it, and by default it does nothing.

/// What is ignored stays so, as under nohup or in the background of a script.
sigset_t watched_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, kWake);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action = {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals, signal);
  }
  return signals;
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void hold_watched_signals() {
  const sigset_t signals = watched_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

CancellationSource::CancellationSource(Options options)
    : options_(std::move(options)), signals_(watched_signals()) {
  // Threads made from now on inherit this: the watcher alone takes signals.
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  watcher_ = std::jthread([this](const std::stop_token& over) { watch(over); });
}

CancellationSource::~CancellationSource() {
  watcher_.request_stop();
  pthread_kill(watcher_.native_handle(), kWake);
  watcher_.join();
  // Whoever was told to stop does not die of being told again on the last steps.
  constexpr timespec kNow = {0, 0};
  while (reason_.load() == Reason::kSignal && sigtimedwait(&signals_, nullptr, &kNow) > 0) {
  }
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
}

void CancellationSource::begin(double limit_s) {
  {
    const std::lock_guard guard(deciding_);
    keeps_results_ = false;
    if (reason_.load() == Reason::kSignal) abandon_.request_stop();
  }
  limit_s_ = limit_s;
  end_s_.store(seconds_now() + limit_s);
}

void CancellationSource::keep_results() {
  const std::lock_guard guard(deciding_);
  if (abandon_.stop_requested()) throw Cancelled();
  keeps_results_ = true;
}

void CancellationSource::watch(const std::stop_token& over) {
  constexpr timespec kLook = {0, 20'000'000};  // 20 ms
  double give_up_s = std::numeric_limits<double>::infinity();
  while (!over.stop_requested()) {
    const int signal = sigtimedwait(&signals_, nullptr, &kLook);
    if (signal > 0 && signal != kWake) {
      if (reason_.load() == Reason::kSignal) options_.give_up();
      stop(Reason::kSignal);
    }
    if (seconds_now() > end_s_.load() && !source_.stop_requested()) stop(Reason::kTime);
    if (abandon_.stop_requested()) {
      if (give_up_s > seconds_now() + options_.patience_s) give_up_s = seconds_now() + options_.patience_s;
      if (seconds_now() > give_up_s) options_.give_up();
    }
    if (options_.on_tick) options_.on_tick();
  }
}

void CancellationSource::stop(Reason reason) {
  const bool keeps = [&] {
    const std::lock_guard guard(deciding_);
    reason_.store(reason);
    source_.request_stop();
    if (!keeps_results_) abandon_.request_stop();
    return keeps_results_;
  }();
  if (keeps && options_.on_kept) options_.on_kept(reason);
}

}  // namespace lumesh::parallel
