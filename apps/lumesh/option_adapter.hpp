#pragma once
/// @file Options of stages on the command line: made from their descriptions (core/option.hpp).

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>
#include <string_view>

#include "lumesh/core/option.hpp"

namespace lumesh::cli {

/// The names of an option, which CLI11 takes: "--split-above,--cdff"; an alias of one letter is "-m". Of a
/// list the alias, its singular, comes first; a switch that is on by default is "--no-NAME".
[[nodiscard]] std::string flags_of(const Option& option);

/// Adds every option of a list to a command: what the command line says goes to the targets, which have to
/// live as long as the command. Values out of range, and options that exclude or need others, are refused.
/// @param group  Heading in the help; empty: that of all options. @param without  Names that are left out.
void add_options(CLI::App& command, const OptionList& list, const std::string& group = "",
                 std::initializer_list<std::string_view> without = {});

/// The same for the options of a struct.
template <class Described>
void add_options_of(CLI::App& command, Described& described) {
  add_options(command, options_of(described));
}

/// @throws Error{kUsage} "--NAME REASON; leave it out" for an option of the list that the command line gives.
/// @param without  Names that may be given.
void require_not_given(const CLI::App& command, const OptionList& list, const std::string& reason,
                       std::initializer_list<std::string_view> without = {});

/// A message of the library with options as this command, or another one of the program, has them.
[[nodiscard]] std::string with_flags(std::string_view message, const CLI::App& command);

}  // namespace lumesh::cli
