#pragma once
/// @file Texts of files; pages, numbers and pictures to files, as safely as meshes.

#include <filesystem>
#include <string>
#include <string_view>

namespace lumesh {

/// Writes beside the target and renames when complete; a link's file is replaced, not the link; devices and
/// pipes are written directly. A file that is there keeps its permissions.
/// @throws Error{kBadInput} if it cannot be written; nothing is left behind then.
void write_text_file(const std::filesystem::path& path, std::string_view content);

/// @throws Error{kBadInput} if it is no regular file or cannot be read.
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path);

}  // namespace lumesh
