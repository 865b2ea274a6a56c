#include "lumesh/parallel/stopper.hpp"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>

namespace lumesh::parallel {
namespace {

constexpr int kExitCode = 4;  // Of the program, when the second signal comes.

sigset_t watched_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

}  // namespace

Stopper::Stopper(double limit_s) {
  // Threads made from now on inherit this: the watcher alone takes signals.
  const sigset_t signals = watched_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  watcher_ = std::jthread([this, limit_s](const std::stop_token& over) { watch(limit_s, over); });
}

Stopper::~Stopper() {
  watcher_.request_stop();
  watcher_.join();
  const sigset_t signals = watched_signals();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

void Stopper::watch(double limit_s, const std::stop_token& over) {
  constexpr timespec kLook = {0, 20'000'000};  // 20 ms
  const auto start = std::chrono::steady_clock::now();
  const sigset_t signals = watched_signals();
  while (!over.stop_requested()) {
    if (sigtimedwait(&signals, nullptr, &kLook) > 0) {
      if (source_.stop_requested()) std::_Exit(kExitCode);
      stop(Reason::kSignal);
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    if (elapsed.count() > limit_s && !source_.stop_requested()) stop(Reason::kTime);
  }
}

void Stopper::stop(Reason reason) {
  reason_.store(reason);
  source_.request_stop();
}

}  // namespace lumesh::parallel
