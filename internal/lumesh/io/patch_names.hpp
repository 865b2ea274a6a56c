#pragma once
/// @file Whether names of patches are kept in files.

#include <filesystem>

namespace lumesh {

/// Whether a file of this name, which a mesh is written to, has a place for the names of its patches.
[[nodiscard]] bool keeps_patch_names(const std::filesystem::path& path);
/// Whether it gets the outer boundary alone, since it cannot tell faces between cells from the others.
[[nodiscard]] bool is_boundary_alone(const std::filesystem::path& path);

}  // namespace lumesh
