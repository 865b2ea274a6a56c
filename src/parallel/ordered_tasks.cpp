#include "lumesh/parallel/ordered_tasks.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <queue>
#include <thread>

namespace lumesh::parallel {
namespace {

/// The tasks that may run now, and how many predecessors the others still wait for. One mutex guards it all:
/// a task takes milliseconds.
class ReadyTasks {
 public:
  explicit ReadyTasks(const TaskGraph& conflicts)
      : conflicts_(conflicts),
        colours_(colours_of(conflicts)),
        waits_for_(conflicts.size()),
        left_(conflicts.size()) {
    for (std::uint32_t task = 0; task < conflicts.size(); ++task) {
      const auto before = conflicts.neighbours(task);
      waits_for_[task] = static_cast<std::uint32_t>(std::count_if(
          before.begin(), before.end(), [&](std::uint32_t other) { return precedes(other, task); }));
      if (waits_for_[task] == 0) ready_.push({colours_[task], task});
    }
  }

  /// Waits for a task. @return false when all are done or one has failed.
  bool take(std::uint32_t& task) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !ready_.empty() || left_ == 0 || failure_; });
    if (left_ == 0 || failure_) return false;
    task = ready_.top().second;
    ready_.pop();
    return true;
  }

  void done(std::uint32_t task) {
    const std::lock_guard lock(mutex_);
    std::size_t woken = 0;
    for (const std::uint32_t other : conflicts_.neighbours(task)) {
      if (precedes(other, task) || --waits_for_[other] > 0) continue;
      ready_.push({colours_[other], other});
      ++woken;
    }
    if (--left_ == 0) {
      changed_.notify_all();
    } else {
      for (; woken > 1; --woken) changed_.notify_one();  // The caller takes one of them itself.
    }
  }

  void failed(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
    changed_.notify_all();
  }
  [[nodiscard]] std::exception_ptr failure() const { return failure_; }

 private:
  [[nodiscard]] bool precedes(std::uint32_t a, std::uint32_t b) const {
    return std::pair(colours_[a], a) < std::pair(colours_[b], b);
  }

  using Ranked = std::pair<std::uint32_t, std::uint32_t>;
  const TaskGraph& conflicts_;
  std::vector<std::uint32_t> colours_;
  std::vector<std::uint32_t> waits_for_;
  std::priority_queue<Ranked, std::vector<Ranked>, std::greater<>> ready_;
  std::size_t left_;
  std::exception_ptr failure_;
  std::mutex mutex_;
  std::condition_variable changed_;
};

}  // namespace

int available_threads() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

std::vector<std::uint32_t> colours_of(const TaskGraph& conflicts) {
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> colours(conflicts.size(), kNone), seen;  // seen[c] == task: a neighbour has it.
  for (std::uint32_t task = 0; task < conflicts.size(); ++task) {
    for (const std::uint32_t other : conflicts.neighbours(task)) {
      if (colours[other] == kNone) continue;
      if (colours[other] >= seen.size()) seen.resize(colours[other] + 1, kNone);
      seen[colours[other]] = task;
    }
    std::uint32_t colour = 0;
    while (colour < seen.size() && seen[colour] == task) ++colour;
    colours[task] = colour;
  }
  return colours;
}

void run_ordered(const TaskGraph& conflicts, int threads,
                 const std::function<void(std::uint32_t, int)>& body) {
  ReadyTasks ready(conflicts);
  const auto work = [&](int thread) {
    try {
      for (std::uint32_t task = 0; ready.take(task); ready.done(task)) body(task, thread);
    } catch (...) {
      ready.failed(std::current_exception());
    }
  };
  {
    std::vector<std::jthread> team;
    for (int thread = 1; thread < threads; ++thread) team.emplace_back(work, thread);
    work(0);
  }
  if (ready.failure()) std::rethrow_exception(ready.failure());
}

}  // namespace lumesh::parallel
