#pragma once
/// @file Surfaces from files whose patches somebody chooses.

#include <filesystem>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// read_mesh(), with patches by an array that the caller names. Warns of names of solids and groups that
/// patches cannot have.
/// @param patch_array  Of .vtp: an array of whole numbers of the cells; each number N that occurs is the
/// patch face_N. Empty: `patch`, ModelFaceID or CellEntityIds, the first that is there. An array that holds
/// one number only tells nothing, and counts as if it were not there.
/// @throws Error{kBadInput} as read_mesh(), and if there is no such array; the text lists those that are.
[[nodiscard]] MixedMesh read_surface_file(const std::filesystem::path& path, const std::string& patch_array,
                                          const Context& context);

}  // namespace lumesh
