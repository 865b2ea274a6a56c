#include "lumesh/core/error.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {

void find_named_openings(CaseState& state) {
  if (state.c.openings.names.empty()) return;
  naming("[openings] names", [&] {
    state.renamings = with_patches(renamings_from(state.c.openings.names), named_openings(state.openings()));
  });
}

std::vector<std::string> name_patches_of_case(CaseState& state, report::StageReport& last) {
  MeshInfo& info = state.layered ? state.layered->info : state.mesh.info();
  const std::vector<std::string> missing = rename_found(info, state.renamings);
  for (const std::string& line : missing) {
    state.context.warn(line);
    last.warnings.push_back(line);
  }
  return missing;
}

}  // namespace lumesh::pipeline
