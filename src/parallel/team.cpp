#include "lumesh/parallel/team.hpp"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include "lumesh/core/error.hpp"

namespace lumesh::parallel {

namespace {

bool wants_pins(const TeamOptions& options, const Topology& topology) {
  if (!topology.is_this_machine() || options.pin == Pinning::kOff) return false;
  return options.pin == Pinning::kOn || (goes_by_distance(options.balance) && topology.nodes() > 1);
}

}  // namespace

Team::Team(const TeamOptions& options)
    : options_(options),
      topology_(options.synthetic_topology.empty() ? Topology::of_machine()
                                                   : Topology::synthetic(options.synthetic_topology)),
      pins_(wants_pins(options, topology_)) {
  const int threads = std::max(1, options.threads);
  for (int thread = 0; thread < threads; ++thread) nodes_.push_back(topology_.node_of(thread, threads));
  migrations_.resize(nodes_.size());
  try {
    for (int thread = 1; thread < threads; ++thread) {
      Worker& worker = workers_.emplace_back();
      worker.thread = std::thread([this, thread, &worker] { work(thread, worker); });
    }
  } catch (const std::system_error&) {
    stop();
    throw Error(ErrorKind::kMemory, "the system does not give " + std::to_string(threads) +
                                        " threads; ask for fewer with `threads`");
  }
}

Team::~Team() {
  stop();
}

void Team::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (Worker& worker : workers_) worker.begin.notify_one();
  }
  for (Worker& worker : workers_)
    if (worker.thread.joinable()) worker.thread.join();
}

void Team::work(int thread, Worker& mine) {
  std::optional<Topology::Pin> pin;
  if (pins_) pin.emplace(topology_, thread, size());
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      mine.begin.wait(lock, [&] { return stopping_ || mine.has_work; });
      if (stopping_) return;
      mine.has_work = false;
    }
    run_body(thread);
    const std::lock_guard lock(mutex_);
    if (--running_ == 0) all_done_.notify_one();
  }
}

void Team::run_body(int thread) {
  try {
    (*body_)(thread);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::current_exception();
  }
}

void Team::run(int count, const std::function<void(int)>& body) {
  std::optional<Topology::Pin>
      pin;  // For now only: threads that the caller starts elsewhere would inherit it.
  if (pins_) pin.emplace(topology_, 0, size());
  {
    const std::lock_guard lock(mutex_);
    body_ = &body;
    running_ = count - 1;
    for (int i = 0; i + 1 < count; ++i) {
      Worker& worker = workers_[static_cast<std::size_t>(i)];
      worker.has_work = true;
      worker.begin.notify_one();
    }
  }
  run_body(0);
  std::unique_lock lock(mutex_);
  all_done_.wait(lock, [&] { return running_ == 0; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Team::add_migrations(const std::vector<TaskMigrations>& more) {
  for (std::size_t thread = 0; thread < more.size(); ++thread) migrations_[thread] += more[thread];
}

}  // namespace lumesh::parallel
