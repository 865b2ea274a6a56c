#pragma once
/// @file Files that may be gzipped, as a whole.

#include <filesystem>
#include <string>

namespace lumesh::io {

/// The bytes of a file, unpacked if it is gzipped.
/// @throws Error{kBadInput} if it cannot be read or is damaged, Error{kMemory} if it does not fit.
[[nodiscard]] std::string unpacked_file(const std::filesystem::path& path);

}  // namespace lumesh::io
