#pragma once
/// @file Work that is ended from outside: every loop of loops.hpp and tasks.hpp is a place where it may end.

#include <tbb/task_group.h>

#include <exception>
#include <stop_token>

namespace lumesh::parallel {

/// Thrown by work that was told to stop. Not an Error: nothing is wrong, and nobody who handles errors shall
/// take it for one.
class Cancelled : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "cancelled"; }
};

/// Whether the run_cancellable() that this runs in was told to stop; false outside of one. Takes some 25 ns.
[[nodiscard]] inline bool is_cancelled() {
  return tbb::is_current_task_group_canceling();
}

/// For long work that runs no loops of this module.
/// @throws Cancelled if is_cancelled().
inline void check_cancelled() {
  if (is_cancelled()) throw Cancelled();
}

/// Runs `work` on this thread. Once `stop` is requested, loops of this module within it, nested ones, too,
/// begin no further block, and end in Cancelled; so do those that begin later. May be nested; threads of a
/// Team are not reached (sweeps of operators ask the token themselves).
/// @throws Cancelled if `work` did not run to its end for that reason, and what `work` throws.
template <class Work>
void run_cancellable(const std::stop_token& stop, const Work& work) {
  tbb::task_group_context scope;
  tbb::task_group group(scope);
  bool is_done = false;
  group.run_and_wait([&] {
    // Not before: a scope within another one takes over its state as it begins, and forgets a stop.
    const std::stop_callback cancel(stop, [&] { scope.cancel_group_execution(); });
    if (is_cancelled()) return;
    work();
    is_done = true;
  });
  if (!is_done) throw Cancelled();
}

}  // namespace lumesh::parallel
