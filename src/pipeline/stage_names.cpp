#include "lumesh/core/error.hpp"
#include "lumesh/domain/openings.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {

void find_named_openings(CaseState& state) {
  if (state.c.openings.names.empty()) return;
  naming("[openings] names", [&] {
    state.renamings =
        with_patches(renamings_from(state.c.openings.names), named_openings(find_openings(state.domain())));
  });
}

void name_patches_of_case(CaseState& state, report::StageReport& last) {
  MeshInfo& info = state.layered ? state.layered->info : state.mesh.info();
  for (std::string& missing : rename_found(info, state.renamings)) {
    state.context.warn(missing);
    last.warnings.push_back(std::move(missing));
  }
}

}  // namespace lumesh::pipeline
