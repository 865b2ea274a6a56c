#pragma once
/// @file Lists of patches in which a name stands once.

#include <algorithm>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::detail {

/// The number of a patch of this name and kind, added where there is none. Where one of another kind has the
/// name, the wanted one gets a number behind it.
inline std::int32_t patch_number(std::vector<Patch>& patches, const Patch& wanted) {
  std::string name = wanted.name;
  for (int next = 2;; ++next) {
    const auto same =
        std::find_if(patches.begin(), patches.end(), [&](const Patch& patch) { return patch.name == name; });
    if (same == patches.end()) break;
    if (same->kind == wanted.kind) return static_cast<std::int32_t>(same - patches.begin());
    name = wanted.name + "_" + std::to_string(next);
  }
  patches.push_back({name, wanted.kind, wanted.labels});
  return static_cast<std::int32_t>(patches.size()) - 1;
}

/// Name of the patch between two labels, the lower one first.
[[nodiscard]] inline std::string name_between(Label a, Label b) {
  return "interface_" + std::to_string(std::min(a, b)) + "_" + std::to_string(std::max(a, b));
}

}  // namespace lumesh::detail
