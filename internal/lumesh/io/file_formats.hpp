#pragma once
/// @file Which file names serve which use, and the formats of each use for help and messages.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"

namespace lumesh {

struct Option;

/// Whether a file of this name can be used so. Of images that are read the content decides, not the name.
[[nodiscard]] bool is_for(const std::filesystem::path& path, FileUse use);

/// @throws Error "PATH: unknown mesh format; use .vtu or .vtk" unless a file of this name can be used so.
void require_format(const std::filesystem::path& path, FileUse use, ErrorKind kind = ErrorKind::kBadInput);

/// The formats that can be used so, for help and messages: ".vtu, .vtk or .foam for OpenFOAM". Packed ones,
/// such as .vtk.gz, go without saying.
[[nodiscard]] std::string formats_for(FileUse use, std::string_view before_last = ", ");

/// Names of the formats that formats_for() lists, packed ones, too.
[[nodiscard]] std::vector<std::string_view> format_names(FileUse use);

/// Every use with its words, such as "write volume".
[[nodiscard]] std::vector<std::pair<FileUse, std::string_view>> file_uses();

/// The meaning of an option, with the formats of the files that it takes.
[[nodiscard]] std::string meaning_of(const Option& option);

}  // namespace lumesh
