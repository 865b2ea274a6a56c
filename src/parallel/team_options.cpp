#include "lumesh/core/option.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::parallel {

void TeamOptions::describe(OptionList& list) {
  list.choice(
      "balance", balance,
      {{"none", Balance::kNone},
       {"first-idle", Balance::kFirstIdle},
       {"hierarchical", Balance::kHierarchical},
       {"node-first", Balance::kNodeFirst},
       {"stealing", Balance::kStealing}},
      "Who gives work to idle threads: nobody; the busy to the one that idles longest, or to the nearest by "
      "NUMA distance, node-first only where no busy thread of that node could; or idle threads take it by "
      "chance. Changes time only");
  list.choice(
      "pin", pin, {{"auto", Pinning::kAuto}, {"on", Pinning::kOn}, {"off", Pinning::kOff}},
      "Keep every thread on its processor; auto: where idle threads are chosen by distance, on machines of "
      "several NUMA nodes. Programs that run side by side there need processors of their own (numactl, "
      "taskset), or off",
      {{"true", "on"}, {"false", "off"}});
}

}  // namespace lumesh::parallel
