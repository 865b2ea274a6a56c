#pragma once
/// @file Where an output goes whose name is a symbolic link.

#include <filesystem>

namespace lumesh::io {

/// The path that a symbolic link leads to, over others, also where nothing is there yet; other paths as they
/// are.
/// @throws Error{kBadInput} for links that lead round in a circle.
[[nodiscard]] std::filesystem::path link_target(std::filesystem::path path);

}  // namespace lumesh::io
