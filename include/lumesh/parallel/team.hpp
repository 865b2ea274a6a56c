#pragma once
/// @file Threads that stay, pinned if wanted, and how they share their work.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "lumesh/parallel/topology.hpp"

namespace lumesh {
class OptionList;
}

namespace lumesh::parallel {

/// Balancing policies. Every task has a home, the thread that it belongs to at first.
enum class Balance : std::uint8_t {
  kNone,          ///< Nobody: every thread runs its own tasks.
  kFirstIdle,     ///< A busy thread gives half of its tasks, the coldest, to the thread that idles longest.
  kNodeFirst,     ///< As kHierarchical, but idle threads of other nodes are left to the busy ones there as
                  ///< long as these have something to give.
  kStealing,      ///< An idle thread takes half of the tasks of another, by chance.
  kHierarchical,  ///< As kFirstIdle, but to the idle thread at the lowest NUMA distance (the paper's
                  ///< algorithm 1).
};

[[nodiscard]] constexpr bool goes_by_distance(Balance balance) {
  return balance == Balance::kNodeFirst || balance == Balance::kHierarchical;
}

/// Whether every thread is kept on its processor.
enum class Pinning : std::uint8_t {
  kAuto,  ///< Where node distances count: under policies that go by them, on a machine of several NUMA nodes.
  kOn,
  kOff,
};

struct TeamOptions {
  int threads = 1;  ///< >= 1
  Balance balance = Balance::kNodeFirst;
  Pinning pin = Pinning::kAuto;
  std::string synthetic_topology =
      {};  ///< Topology::synthetic(): balance as if on that machine, pin nothing.

  /// Without the threads and the topology.
  void describe(OptionList& list);
};

/// Numbers of tasks that migrated to a thread, from its own NUMA node and from other ones.
struct TaskMigrations {
  std::uint64_t local = 0, remote = 0;

  TaskMigrations& operator+=(const TaskMigrations& other) {
    local += other.local;
    remote += other.remote;
    return *this;
  }
};

/// Threads 0 to size() - 1, of which 0 is the one that calls run().
class Team {
 public:
  /// @throws Error{kUsage} for a topology that is none, Error{kMemory} if the system has no more threads.
  explicit Team(const TeamOptions& options);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] Balance balance() const { return options_.balance; }
  /// Never true on a synthetic topology.
  [[nodiscard]] bool pins() const { return pins_; }
  [[nodiscard]] const Topology& topology() const { return topology_; }
  [[nodiscard]] int node_of(int thread) const { return nodes_[static_cast<std::size_t>(thread)]; }

  /// Runs body(thread) on threads 0 to count - 1 and waits for all of them. The first exception is thrown
  /// here.
  void run(int count, const std::function<void(int)>& body);

  /// Task migrations by receiving thread, summed over all runs of the team.
  [[nodiscard]] const std::vector<TaskMigrations>& migrations() const { return migrations_; }
  void add_migrations(const std::vector<TaskMigrations>& more);

 private:
  struct Worker {
    std::condition_variable begin;
    bool has_work = false;
    std::thread thread;
  };

  void work(int thread, Worker& mine);
  void run_body(int thread);
  void stop();

  TeamOptions options_;
  Topology topology_;
  bool pins_;
  std::vector<int> nodes_;  // NUMA node of each thread.
  std::vector<TaskMigrations> migrations_;
  std::deque<Worker> workers_;  // Of threads 1, 2, ...
  std::mutex mutex_;            // Guards all below, and has_work.
  std::condition_variable all_done_;
  const std::function<void(int)>* body_ = nullptr;
  int running_ = 0;
  bool stopping_ = false;
  std::exception_ptr failure_;
};

}  // namespace lumesh::parallel
