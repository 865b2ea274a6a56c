#pragma once
/// @file Surfaces from files whose patches somebody chooses.

#include <filesystem>
#include <string>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct SurfaceFile {
  MixedMesh mesh;
  std::string
      renamed;  ///< Line on names of solids and groups that patches cannot have; empty if there are none.
};

/// read_mesh(), with patches by an array that the caller names, and what became of names.
/// @param patch_array  Of .vtp: an array of whole numbers of the cells; each number N that occurs is the
/// patch face_N. Empty: `patch`, ModelFaceID or CellEntityIds, the first that is there. An array that holds
/// one number only tells nothing, and counts as if it were not there.
/// @throws Error{kBadInput} as read_mesh(), and if there is no such array; the text lists those that are.
[[nodiscard]] SurfaceFile read_surface_file(const std::filesystem::path& path,
                                            const std::string& patch_array);

}  // namespace lumesh
