#pragma once
/// @file Names of files from programs that write Latin-1.

#include <string>

namespace lumesh::io {

/// The text, if it is UTF-8; else what it is if its bytes are Latin-1.
[[nodiscard]] std::string as_utf8(std::string text);

}  // namespace lumesh::io
