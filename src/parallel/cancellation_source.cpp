#include "lumesh/parallel/cancellation_source.hpp"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>

namespace lumesh::parallel {
namespace {

constexpr int kExitCode = 4;  // Of the program, when it gives up.

/// What is ignored stays so, as under nohup or in the background of a script.
sigset_t watched_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action = {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals, signal);
  }
  return signals;
}

}  // namespace

CancellationSource::CancellationSource(Options options)
    : options_(std::move(options)), signals_(watched_signals()) {
  // Threads made from now on inherit this: the watcher alone takes signals.
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  watcher_ = std::jthread([this](const std::stop_token& over) { watch(over); });
}

CancellationSource::~CancellationSource() {
  watcher_.request_stop();
  watcher_.join();
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
}

void CancellationSource::watch(const std::stop_token& over) {
  constexpr timespec kLook = {0, 20'000'000};  // 20 ms
  const auto seconds = [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  double give_up_s = std::numeric_limits<double>::infinity();
  int count = 0;
  while (!over.stop_requested()) {
    if (sigtimedwait(&signals_, nullptr, &kLook) > 0) {
      if (++count > 1) give_up();
      if (!source_.stop_requested()) stop(Reason::kSignal);
      give_up_s = seconds() + options_.patience_s;
    }
    if (seconds() > give_up_s && !finishes_.load()) give_up();
    if (seconds() > options_.limit_s && !source_.stop_requested()) stop(Reason::kTime);
  }
}

void CancellationSource::give_up() const {
  if (options_.give_up) options_.give_up(finishes_.load());
  std::_Exit(kExitCode);
}

void CancellationSource::stop(Reason reason) {
  reason_.store(reason);
  source_.request_stop();
}

}  // namespace lumesh::parallel
