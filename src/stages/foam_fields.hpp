#pragma once
// Start values of an OpenFOAM case, which are the user's, against the patches of a mesh that is put there.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace lumesh {

/// A patch of the boundary, as OpenFOAM knows it.
struct FoamPatch {
  std::string name;
  std::string group;  ///< Empty for none.
};

/// A line that tells which patches files of the folder `0` have no entry for, and which entries no patch;
/// empty if each has one, if there are no such files, and for files that name patches by patterns or include
/// others. Solvers stop at such files, as after patches are renamed.
[[nodiscard]] std::string stale_fields_text(const std::filesystem::path& foam_file,
                                            std::span<const FoamPatch> patches);

}  // namespace lumesh
