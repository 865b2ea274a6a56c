#include "lumesh/operators/terms.hpp"

#include "lumesh/core/option.hpp"

namespace lumesh {

void describe_execution(OptionList& list, ExecutionKind& execution, parallel::TeamOptions& team) {
  list.choice("execution", execution,
              {{"ordered", ExecutionKind::kOrdered}, {"speculative", ExecutionKind::kSpeculative}},
              "ordered: bitwise identical for every thread count; speculative: threads lock what they "
              "change, and the mesh differs from run to run, alike in quality");
  team.describe(list);
}

}  // namespace lumesh

namespace lumesh::operators {

OperatorCounts ExecutionCounts::of_all_threads() const {
  OperatorCounts sum;
  for (const OperatorCounts& counts : by_thread) sum += counts;
  return sum;
}

ExecutionCounts& ExecutionCounts::operator+=(const ExecutionCounts& other) {
  by_thread.resize(other.by_thread.size());
  migrations.resize(other.migrations.size());
  for (std::size_t thread = 0; thread < by_thread.size(); ++thread) {
    by_thread[thread] += other.by_thread[thread];
    migrations[thread] += other.migrations[thread];
  }
  return *this;
}

}  // namespace lumesh::operators
