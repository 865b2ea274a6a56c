#pragma once
/// @file Whether names of patches are kept in files.

#include <filesystem>

namespace lumesh {

/// Whether a file of this name, which a mesh is written to, has a place for the names of its patches.
[[nodiscard]] bool keeps_patch_names(const std::filesystem::path& path);

}  // namespace lumesh
