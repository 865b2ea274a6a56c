#include "kernel_options.hpp"

#include "lumesh/parallel/ordered_tasks.hpp"

namespace lumesh::cli {

void add_topology_option(CLI::App& command, parallel::TeamOptions& team) {
  command
      .add_option("--topology", team.synthetic_topology, "Balance as on this machine, as hwloc describes it")
      ->group("");
}

int threads_of(const RunOptions& run) {
  return run.threads > 0 ? run.threads : parallel::available_threads();
}

void print_counts(const RunOptions& run, const operators::ExecutionCounts& counts) {
  if (run.verbose == 0) return;
  const operators::OperatorCounts all = counts.of_all_threads();
  for (const auto& [id, name] : operators::kOperatorNames) {
    const operators::OperatorCount& count = all[id];
    print_error("lumesh: {}: {} applied, {} rejected, {} contended\n", name, count.applied, count.rejected,
                count.contended);
  }
  for (std::size_t thread = 0; thread < counts.by_thread.size(); ++thread) {
    const operators::OperatorCount count = counts.by_thread[thread].of_all();
    const parallel::TaskMigrations& got = counts.migrations[thread];
    print_error(
        "lumesh: thread {}: {} applied, {} rejected, {} contended; migrated to it: {} local, {} remote\n",
        thread, count.applied, count.rejected, count.contended, got.local, got.remote);
  }
}

}  // namespace lumesh::cli
