#pragma once
/// @file Labels whose cells stay as they are while a command changes the rest.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace lumesh::cli {

/// --keep.
CLI::Option* add_keep_option(CLI::App& command, std::vector<std::string>& labels);

}  // namespace lumesh::cli
