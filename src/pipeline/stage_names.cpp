#include <algorithm>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

/// After the patches themselves, where these took the names.
void rename_coverages(std::span<const PatchRenaming> renamings, const MeshInfo& info, LayerReport& report) {
  for (LayerCoverage& coverage : report.patches) {
    const auto of_patch = std::ranges::find_if(renamings, [&](const PatchRenaming& renaming) {
      return renaming.patch == coverage.patch && has_patch_called(info.patches, renaming.name);
    });
    if (of_patch != renamings.end()) coverage.patch = of_patch->name;
  }
}

}  // namespace

void find_named_openings(CaseState& state) {
  if (state.c.openings.names.empty()) return;
  naming("[openings] names", [&] {
    state.renamings =
        with_patches(renamings_from(state.c.openings.names), named_openings(state.given.openings()),
                     named_openings(state.given.beginnings()));
  });
}

std::vector<std::string> name_patches_of_case(CaseState& state, report::StageReport& last) {
  MeshInfo& info = state.mesh_info();
  const std::vector<PatchRenaming> renamings = std::exchange(state.renamings, {});  // They may swap names.
  const std::vector<std::string> missing = rename_found(info, renamings);
  if (last.layers) rename_coverages(renamings, info, last.layers->report);
  for (const std::string& line : missing) {
    state.context.warn(line);
    last.warnings.push_back(line);
  }
  return missing;
}

}  // namespace lumesh::pipeline
