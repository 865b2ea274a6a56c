#pragma once
/// @file How many threads work, and how they share their work.

#include <cstdint>
#include <string>

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

}  // namespace lumesh::parallel
