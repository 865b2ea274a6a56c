#include "lumesh/parallel/ordered_tasks.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>

#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/work_lists.hpp"

namespace lumesh::parallel {
namespace {

std::vector<std::uint32_t> greedy_colours(const TaskGraph& conflicts) {
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> colours(conflicts.size(), kNone), seen;  // seen[c] == task: a neighbour has it.
  for (std::uint32_t task = 0; task < conflicts.size(); ++task) {
    for (const std::uint32_t other : conflicts.of(task)) {
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

/// Runs body(thread) on as many threads as there are tasks for; an exception ends the lists and is thrown
/// here.
void run_on_lists(Team& team, int threads, WorkLists& lists, const std::function<void(int)>& body) {
  team.run(threads, [&](int thread) {
    try {
      body(thread);
    } catch (...) {
      lists.end();
      throw;
    }
  });
  team.add_migrations(lists.migrations());
}

int threads_for(const Team& team, std::uint32_t tasks) {
  return static_cast<int>(std::min(static_cast<std::uint32_t>(team.size()), tasks));
}

}  // namespace

int available_threads() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

TaskOrder order_of(const TaskGraph& conflicts) {
  TaskOrder order{greedy_colours(conflicts), std::vector<std::uint32_t>(conflicts.size())};
  for_each_index(conflicts.size(), [&](std::size_t i) {
    const auto task = static_cast<std::uint32_t>(i);
    const auto others = conflicts.of(task);
    order.waits_for[i] = static_cast<std::uint32_t>(
        std::ranges::count_if(others, [&](std::uint32_t other) { return order.precedes(other, task); }));
  });
  return order;
}

void run_ordered(Team& team, const TaskGraph& conflicts, const TaskOrder& order,
                 const std::function<void(std::uint32_t, int)>& body) {
  if (conflicts.size() == 0) return;
  const int threads = threads_for(team, conflicts.size());
  WorkLists lists(team, threads, conflicts.size());
  // Each task that is done lowers those of its neighbours; whoever brings one to 0 alone puts that task on a
  // list. Test: OrderedTasksOnThreads.RunEachTaskOnceAndConflictsInTheSameOrder.
  std::vector<std::atomic<std::uint32_t>> waits_for(conflicts.size());
  for (std::uint32_t task = 0; task < conflicts.size(); ++task) {
    waits_for[task].store(order.waits_for[task], std::memory_order_relaxed);  // Team::run() makes it visible.
    if (order.waits_for[task] == 0) lists.put_first({order.colours[task], task});
  }
  run_on_lists(team, threads, lists, [&](int thread) {
    for (std::uint32_t task = 0; lists.take(thread, task); lists.done()) {
      body(task, thread);
      for (const std::uint32_t other : conflicts.of(task)) {
        if (order.precedes(other, task)) continue;
        // Release what this task wrote; the last one acquires what all the others did.
        if (waits_for[other].fetch_sub(1, std::memory_order_acq_rel) == 1)
          lists.put({order.colours[other], other}, thread);
      }
    }
  });
}

void run_freely(Team& team, std::uint32_t tasks, const std::function<TaskEnd(std::uint32_t, int)>& body) {
  if (tasks == 0) return;
  const int threads = threads_for(team, tasks);
  WorkLists lists(team, threads, tasks);
  for (std::uint32_t task = 0; task < tasks; ++task) lists.put_first({0, task});
  run_on_lists(team, threads, lists, [&](int thread) {
    for (std::uint32_t task = 0; lists.take(thread, task);) {
      const TaskEnd end = body(task, thread);
      if (end == TaskEnd::kDone) {
        lists.done();
        continue;
      }
      lists.put_back(task, thread);
      if (end == TaskEnd::kNothingDone) lists.park(thread);
    }
  });
}

}  // namespace lumesh::parallel
