#pragma once
/// @file Threads that stay, pinned if wanted.

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "lumesh/parallel/team_options.hpp"
#include "lumesh/parallel/topology.hpp"

namespace lumesh::parallel {

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
