#include "lumesh/operators/terms.hpp"

#include "lumesh/core/option.hpp"

namespace lumesh {

void describe_execution(OptionList& list, ExecutionKind& execution, parallel::TeamOptions& team) {
  list.choice("execution", execution,
              {{"ordered", ExecutionKind::kOrdered}, {"speculative", ExecutionKind::kSpeculative}},
              "ordered: bitwise identical for every thread count; speculative: threads lock what they "
              "change, and the "
              "mesh differs from run to run, alike in quality");
  team.describe(list);
}

}  // namespace lumesh
