#pragma once
/// @file A list of tasks per thread of a team, and the policies by which they pass from one to another.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <set>
#include <vector>

#include "lumesh/parallel/idle_threads.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::parallel {

/// A task that may run. Lists begin with the lowest rank; what stands last is the coldest.
struct RankedTask {
  std::uint32_t rank, task;
  auto operator<=>(const RankedTask&) const = default;
};

/// Every task is taken once for each time that it was put in. Threads without work sleep, and are counted
/// active again by whoever wakes them, before they wake: all end when the last task is done, for every
/// number of threads. One mutex guards it all: a task takes milliseconds, a change of the lists less than a
/// microsecond.
class WorkLists {
 public:
  /// For threads 0 to threads - 1 of `team`, all of them active, and tasks 0 to tasks - 1. The home of a task
  /// is the thread at the same share of the threads: what is near by number stays together.
  WorkLists(const Team& team, int threads, std::uint32_t tasks);

  /// Puts a task in its home's list, before the threads begin.
  void put_first(RankedTask one);
  /// Puts a task that may run now in its home's list, or, where home is busy, in that of an idle thread, as
  /// the policy wants it. @param by  The thread that calls.
  void put(RankedTask one, int by);
  /// Puts a task back of which something is left, at the end of its thread's list.
  void put_back(std::uint32_t task, int thread);
  /// Waits for a task. @return false when all are done, or end() was called.
  [[nodiscard]] bool take(int thread, std::uint32_t& task);
  /// A task is done, and what follows from it has been put in.
  void done();
  /// Waits until another thread has finished a task, become idle, or been parked as the last active one: that
  /// wakes one parked thread and takes its place. Returns at once if no other is active or parked: somebody
  /// always goes on.
  void park(int thread);
  /// No more tasks are handed out.
  void end();

  /// Task migrations by receiving thread.
  [[nodiscard]] const std::vector<TaskMigrations>& migrations() const { return migrations_; }

 private:
  struct Member {
    std::set<RankedTask> tasks;
    std::condition_variable woken;
    bool waits = false;
    bool can_share = false;  // Has two tasks.
  };

  [[nodiscard]] int home_of(std::uint32_t task) const;
  [[nodiscard]] Member& member(int thread) { return members_[static_cast<std::size_t>(thread)]; }
  [[nodiscard]] int receiver_instead_of(int home, int by) const;
  void add_task(int thread, RankedTask one);
  /// To be called when the tasks of a thread have changed.
  void note_tasks(int thread);
  void share(int thread);
  void steal(int thread);
  /// Migrates the coldest half of the tasks of one thread to another.
  void migrate_half(int from, int to);
  void count_migration(int from, int to, std::uint64_t tasks);
  void wake_idle(int thread);
  void wake_one_parked();
  void wake_all();
  void sleep(int thread, std::unique_lock<std::mutex>& lock);
  [[nodiscard]] bool is_over() const { return left_ == 0 || ended_; }

  const Team& team_;
  Balance balance_;
  std::uint32_t tasks_;
  std::deque<Member> members_;
  std::vector<TaskMigrations> migrations_;
  IdleThreads idle_;
  std::vector<int> can_share_;  // Threads of each node.
  std::deque<int> parked_;
  int active_;                // Threads neither idle nor parked.
  std::uint32_t left_;        // Tasks that are not done.
  std::uint32_t rounds_ = 0;  // Last rank of what was put back.
  std::uint64_t random_ = 1;
  bool ended_ = false;
  std::mutex mutex_;
};

}  // namespace lumesh::parallel
