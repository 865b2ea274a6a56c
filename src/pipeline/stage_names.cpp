#include <fmt/core.h>

#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/openings.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

bool has_patch(const MeshInfo& info, const std::string& name) {
  return std::any_of(info.patches.begin(), info.patches.end(),
                     [&](const Patch& patch) { return patch.name == name; });
}

}  // namespace

void find_named_openings(CaseState& state) {
  if (state.c.openings.names.empty()) return;
  std::vector<PatchRenaming> renamings;
  for (const std::string& text : state.c.openings.names) renamings.push_back(renaming_from(text));
  naming("[openings] names", [&] {
    state.renamings = with_patches(std::move(renamings), named_openings(find_openings(state.domain())));
  });
}

void name_patches_of_case(CaseState& state, report::StageReport& last) {
  MeshInfo& info = state.layered ? state.layered->info : state.mesh.info();
  std::vector<PatchRenaming> found;
  for (const PatchRenaming& renaming : state.renamings) {
    if (has_patch(info, renaming.patch)) {
      found.push_back(renaming);
    } else {
      last.warnings.push_back(fmt::format("the mesh has no {} to call {}", renaming.patch, renaming.name));
      state.context.warn(last.warnings.back());
    }
    // The ring that layers make of an opening is called after it.
    if (const std::string ring = renaming.patch + "_layer"; has_patch(info, ring))
      found.push_back({ring, {}, renaming.name + "_layer"});
  }
  rename_patches(info, found);
}

}  // namespace lumesh::pipeline
