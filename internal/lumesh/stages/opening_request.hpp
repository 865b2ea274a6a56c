#pragma once
/// @file What front ends ask of the openings of meshes.

#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/patch_renaming.hpp"

namespace lumesh {

struct OpeningRequest {
  std::vector<std::string> names;  ///< Texts for renaming_from().
  bool is_strict = false;          ///< Openings have to be there, whole and as large as in the domain.

  /// The names as patches of a mesh of the domain are to get them; known before it is made.
  /// @param beginnings  The same openings before they were extended; none where they were not.
  /// @throws Error{kBadInput} as with_patches().
  [[nodiscard]] std::vector<PatchRenaming> renamings(std::span<const Opening> openings,
                                                     std::span<const Opening> beginnings) const;
  /// @param path  Of the mesh. @param without_name  Lines of rename_found().
  /// @throws Error{kNotReached} if a patch that has a name by the user is missing, or if the user is strict
  /// and an opening is missing or wrong.
  void require(const std::string& path, const OpeningsCompared& openings,
               const std::vector<std::string>& without_name) const;
};

/// The openings of a mesh against its domain's; warns of those that are wrong.
[[nodiscard]] OpeningsCompared checked_openings(const MeshView& mesh, const Domain& domain,
                                                std::span<const Opening> openings, Context& context);

}  // namespace lumesh
