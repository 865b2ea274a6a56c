#pragma once
/// @file Names that users give to patches, such as those that a solver's boundary conditions stand on.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A place written as "x,y,z"; none if it is anything else, or not finite.
[[nodiscard]] std::optional<Vec3> place_from(std::string_view text);

/// A patch and the name that it is to have.
struct PatchRenaming {
  std::string patch;                 ///< Its name so far; empty if a place says which opening is meant.
  std::optional<Vec3> near_mm = {};  ///< Near the centre of an opening.
  std::string name;
};

/// Of "outlet_2=left_ica", or with a place in mm, "12.5,40,-3=left_ica".
/// @throws Error{kUsage} if the text is none, or the name has other characters than letters, digits, '_', '-'
/// and '.', or does not begin with a letter or '_': solvers take such names only.
[[nodiscard]] PatchRenaming renaming_from(std::string_view text);

/// The same of several texts.
[[nodiscard]] std::vector<PatchRenaming> renamings_from(std::span<const std::string> texts);

/// An opening that renamings may mean.
struct NamedOpening {
  std::string name;
  Vec3 centre_mm = Vec3::Zero();
  double radius_mm = 0;  ///< Of the circle with its area.
  bool is_rim = false;   ///< Of a wall, around the opening that a place there means.
};

/// Those of a mesh: its patches of PatchKind::kOpening.
[[nodiscard]] std::vector<NamedOpening> named_openings(const MeshView& mesh);

/// Puts the openings that places mean into renamings.
/// @throws Error{kBadInput} if no opening's centre is within twice its radius of a place; if a name that
/// begins with inlet or outlet is none of these; if two renamings mean one patch or give one name. The text
/// lists the openings.
[[nodiscard]] std::vector<PatchRenaming> with_patches(std::vector<PatchRenaming> renamings,
                                                      std::span<const NamedOpening> openings);

/// Renames all at once, so that names may be swapped. What was a wall and gets a name that begins with inlet
/// or outlet is an opening from then on, as in files that say no more of patches than their names.
/// @param renamings  With patches.
/// @throws Error{kBadInput} if a patch is not there, or two would have one name; nothing is changed then.
void rename_patches(MeshInfo& info, std::span<const PatchRenaming> renamings);

/// rename_patches() of what is there, with the rings PATCH_layer that layers make of openings.
/// @return A line for each patch that is not there.
[[nodiscard]] std::vector<std::string> rename_found(MeshInfo& info, std::span<const PatchRenaming> renamings);

}  // namespace lumesh
