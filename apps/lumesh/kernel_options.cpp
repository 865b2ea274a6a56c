#include "kernel_options.hpp"

#include <fmt/core.h>

#include <cstdio>

#include "lumesh/parallel/ordered_tasks.hpp"

namespace lumesh::cli {

namespace {

nlohmann::ordered_json migrations_json(const parallel::TaskMigrations& migrations) {
  return {{"local", migrations.local}, {"remote", migrations.remote}};
}

parallel::TaskMigrations sum_of(const std::vector<parallel::TaskMigrations>& all) {
  parallel::TaskMigrations sum;
  for (const parallel::TaskMigrations& one : all) sum += one;
  return sum;
}

}  // namespace

void add_topology_option(CLI::App& command, parallel::TeamOptions& team) {
  command
      .add_option("--topology", team.synthetic_topology, "Balance as on this machine, as hwloc describes it")
      ->group("");
}

int threads_of(const RunOptions& run) {
  return run.threads > 0 ? run.threads : parallel::available_threads();
}

nlohmann::ordered_json counts_json(const operators::OperatorCounts& counts) {
  nlohmann::ordered_json json;
  for (const auto& [name, member] : operators::OperatorCounts::all()) {
    const operators::OperatorCount& count = counts.*member;
    json[name] = {{"applied", count.applied}, {"rejected", count.rejected}, {"contended", count.contended}};
  }
  return json;
}

void add_counts_json(nlohmann::ordered_json& report, const operators::ExecutionCounts& counts) {
  report["operators"] = counts_json(counts.of_all_threads());
  report["hand_overs"] = migrations_json(sum_of(counts.migrations));
  report["threads"] = nlohmann::ordered_json::array();
  for (std::size_t thread = 0; thread < counts.by_thread.size(); ++thread)
    report["threads"].push_back({{"operators", counts_json(counts.by_thread[thread])},
                                 {"hand_overs", migrations_json(counts.migrations[thread])}});
}

void print_counts(const RunOptions& run, const operators::ExecutionCounts& counts) {
  if (run.verbose == 0) return;
  const operators::OperatorCounts all = counts.of_all_threads();
  for (const auto& [name, member] : operators::OperatorCounts::all()) {
    const operators::OperatorCount& count = all.*member;
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
