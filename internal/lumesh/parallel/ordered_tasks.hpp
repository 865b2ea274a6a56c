#pragma once
/// @file Tasks of which some must not run at the same time, run in a fixed partial order, so that the result
/// is the same for every number of threads; and tasks that run in any order.

#include <cstdint>
#include <functional>
#include <vector>

#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::parallel {

/// For every task the tasks it shares something with, ascending, without itself. Symmetric.
using TaskGraph = Adjacency;

/// Threads that this machine runs at the same time, at least 1.
[[nodiscard]] int available_threads();

/// Which of two tasks in conflict comes first: the one with the lower (colour, index).
struct TaskOrder {
  std::vector<std::uint32_t> colours;    ///< The lowest that no neighbour before (by index) has; greedy.
  std::vector<std::uint32_t> waits_for;  ///< Number of neighbours that come before.

  [[nodiscard]] bool precedes(std::uint32_t a, std::uint32_t b) const {
    return colours[a] != colours[b] ? colours[a] < colours[b] : a < b;
  }
};
[[nodiscard]] TaskOrder order_of(const TaskGraph& conflicts);

/// Calls body(task, thread) once for every task, on the threads of `team`, who runs what by its policy. Of
/// two tasks in conflict the one that comes first by `order` is done, with all it wrote visible, before the
/// other begins; others run freely. Nobody waits while it holds anything, so no number of threads can hang.
/// The first exception of a body ends the run and is thrown here.
void run_ordered(Team& team, const TaskGraph& conflicts, const TaskOrder& order,
                 const std::function<void(std::uint32_t, int)>& body);

/// How a run of a task ended.
enum class TaskEnd : std::uint8_t {
  kDone,
  kSomeLeft,    ///< Some of it contended: it runs again, after the others of its thread.
  kNothingDone  ///< All of it contended: the same, and its thread is parked while others are in its way.
};

/// Calls body(task, thread) for tasks 0 to tasks - 1 until each is done; a task is run by one thread at a
/// time. Always finishes if a body ends in kDone when no other runs: whoever gets nothing done waits for
/// others, but the last active thread never waits. Exceptions as above.
void run_freely(Team& team, std::uint32_t tasks, const std::function<TaskEnd(std::uint32_t, int)>& body);

}  // namespace lumesh::parallel
