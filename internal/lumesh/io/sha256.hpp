#pragma once
/// @file Names for contents: SHA-256 (FIPS 180-4) in hexadecimal.

#include <filesystem>
#include <string>
#include <string_view>

namespace lumesh {

/// SHA-256 of a file's bytes; empty for a folder, since a series of files has no single one.
/// @throws Error{kBadInput} if it cannot be read.
[[nodiscard]] std::string file_sha256(const std::filesystem::path& path);

/// SHA-256 of a text.
[[nodiscard]] std::string text_sha256(std::string_view text);

}  // namespace lumesh
