#pragma once
/// @file Names and kinds that users give to patches, such as those that a solver's boundary conditions stand
/// on.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A place written as "x,y,z"; none if it is anything else, or not finite.
[[nodiscard]] std::optional<Vec3> place_from(std::string_view text);

/// Kind that users give a patch: "inlet", "outlet", "wall" or "symmetry".
struct GivenKind {
  PatchKind kind = PatchKind::kWall;
  FlowSide flow = FlowSide::kUnknown;

  [[nodiscard]] std::string_view word() const;
};

/// A patch and the name that it is to have.
struct PatchRenaming {
  std::string patch;  ///< Its name so far; empty if a place or an area says which opening is meant.
  std::optional<Vec3> near_mm = {};     ///< Near the centre of an opening.
  std::optional<double> area_mm2 = {};  ///< About that of an opening.
  std::string name;
  std::optional<GivenKind> kind = {};  ///< Else it follows from the name, see rename_patches().
};

/// Renaming of a text: "outlet_2=left_ica", with a place in mm, "12.5,40,-3=left_ica", or an area,
/// "7.1mm2=left_ica". Behind the name may stand a kind: "outlet_2=left_ica:inlet".
/// @throws Error{kUsage} if the text is none, or the name has other characters than letters, digits, '_', '-'
/// and '.', or does not begin with a letter or '_': solvers take such names only; or if the kind is none, or
/// not that which files that say no more than names mean by the name (kind_of_name()).
[[nodiscard]] PatchRenaming renaming_from(std::string_view text);

/// Renamings of several texts.
[[nodiscard]] std::vector<PatchRenaming> renamings_from(std::span<const std::string> texts);

/// An opening that renamings may mean.
struct NamedOpening {
  std::string name;
  Vec3 centre_mm = Vec3::Zero();
  double radius_mm = 0;  ///< Radius of the circle with its area.
  bool is_rim = false;   ///< True for a wall's rim around the opening that a place there means.
};

/// Openings of a mesh: its patches of PatchKind::kOpening.
[[nodiscard]] std::vector<NamedOpening> named_openings(const MeshView& mesh);

/// Puts the openings that places and areas mean into renamings.
/// @throws Error{kBadInput} if no opening's centre is within twice its radius of a place; if not exactly one
/// opening has an area within 10 % of the one given; if a name that begins with inlet or outlet is none of
/// these; if two renamings mean one patch or give one name. The text lists the openings.
/// @param beginnings  Further places of these openings, by name: where their flow extensions begin.
[[nodiscard]] std::vector<PatchRenaming> with_patches(std::vector<PatchRenaming> renamings,
                                                      std::span<const NamedOpening> openings,
                                                      std::span<const NamedOpening> beginnings = {});

/// Renames all at once, so that names may be swapped. A patch has the kind given from then on; without one,
/// a new name that begins with inlet, outlet or symmetry gives it, as in files that say no more of patches
/// than their names. Interfaces keep theirs.
/// @param renamings  With patches.
/// @throws Error{kBadInput} if a patch is not there, two would have one name, or an interface is given a
/// kind; nothing is changed then.
void rename_patches(MeshInfo& info, std::span<const PatchRenaming> renamings);

/// rename_patches() of what is there, with the rings PATCH_layer that layers make of openings.
/// @return A line for each patch that is not there, or is given a kind and lies between two labels.
[[nodiscard]] std::vector<std::string> rename_found(MeshInfo& info, std::span<const PatchRenaming> renamings);

}  // namespace lumesh
