#include "lumesh/core/option.hpp"
#include "lumesh/parallel/team.hpp"

namespace lumesh::parallel {

void TeamOptions::describe(OptionList& list) {
  list.choice(
      "balance", balance,
      {{"none", Balance::kNone},
       {"first-idle", Balance::kFirstIdle},
       {"hierarchical", Balance::kHierarchical},
       {"stealing", Balance::kStealing}},
      "Who gives work to idle threads: nobody; the busy to the one that idles longest, or to the nearest by "
      "NUMA distance; or idle threads take it by chance. Changes time only");
  list.flag("pin", pin, "Keep every thread on its processor");
}

}  // namespace lumesh::parallel
