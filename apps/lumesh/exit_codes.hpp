#pragma once
/// @file Exit codes of the program.

#include <string>

#include "lumesh/core/error.hpp"

namespace lumesh::cli {

inline constexpr int kInternalError = 70;  ///< A fault of lumesh.

[[nodiscard]] int exit_code_of(ErrorKind kind);

/// One line on all exit codes, for helps.
[[nodiscard]] std::string exit_codes_text();

}  // namespace lumesh::cli
