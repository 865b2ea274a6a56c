#pragma once
/// @file How every reader and writer says what is wrong with a file.

#include <filesystem>
#include <string_view>

#include "lumesh/core/error.hpp"

namespace lumesh::io {

/// Throws Error: one line, "path: what"; `what` also says what to do.
[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what,
                       ErrorKind kind = ErrorKind::kBadInput);

/// @throws Error{kBadInput} unless it is a regular file that can be opened: devices never end, and pipes may
/// never begin.
void check_file(const std::filesystem::path& path);

}  // namespace lumesh::io
