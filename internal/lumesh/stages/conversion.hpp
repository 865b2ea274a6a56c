#pragma once
/// @file The stages that hand a finished mesh on as it is, in another format or with other names, for every
/// front end. Each warns of faults that no simulation survives.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/stages/mesh_output.hpp"

namespace lumesh {

struct ConversionRequest {
  std::string from;  ///< Path.
  std::string unit;  ///< Unit of lengths in it; empty: as it says.
  /// Names or numbers of labels whose cells are taken, several with commas between them; empty: all.
  std::vector<std::string> only_labels;
  MeshOutput output{.unit = ""};

  void describe(OptionList& list);
};

/// @return The mesh that was written, in its own unit.
/// @throws Error{kBadInput} that names the file, for labels that it does not have, too.
[[nodiscard]] MixedMesh convert_mesh(const ConversionRequest& request, Context& context);

struct RenamingRequest {
  std::string from, to;            ///< Paths.
  std::vector<std::string> names;  ///< Texts for renaming_from().
};

struct RenamedMesh {
  MixedMesh mesh;
  std::vector<PatchRenaming> renamings;  ///< Renamings as they were done, each with its patch.
};

/// @throws Error{kBadInput} that names the file, as with_patches() and rename_patches().
[[nodiscard]] RenamedMesh rename_mesh(const RenamingRequest& request, Context& context);

}  // namespace lumesh
