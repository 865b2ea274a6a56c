#pragma once
/// @file Tasks of which some must not run at the same time, run in a fixed partial order: the result is the
/// same for every number of threads.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace lumesh::parallel {

/// For every task the tasks it shares something with: the neighbours of task i are
/// items[starts[i]] to items[starts[i + 1]], ascending, without i. Symmetric.
struct TaskGraph {
  std::vector<std::uint32_t> starts = {0};
  std::vector<std::uint32_t> items;

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(starts.size() - 1); }
  [[nodiscard]] std::span<const std::uint32_t> neighbours(std::uint32_t task) const {
    return std::span(items).subspan(starts[task], starts[task + 1] - starts[task]);
  }
};

/// Threads that this machine runs at the same time, at least 1.
[[nodiscard]] int available_threads();

/// The lowest colours that no neighbour before (by index) has; greedy.
[[nodiscard]] std::vector<std::uint32_t> colours_of(const TaskGraph& conflicts);

/// Calls body(task, thread) once for every task, on `threads` threads (>= 1). Of two tasks in conflict the
/// one with the lower (colour, index) runs first and is done, with all it wrote visible, before the other
/// begins; others run freely. Nobody waits while it holds anything, so no number of threads can hang. The
/// first exception of a body ends the run and is thrown here.
void run_ordered(const TaskGraph& conflicts, int threads,
                 const std::function<void(std::uint32_t, int)>& body);

}  // namespace lumesh::parallel
