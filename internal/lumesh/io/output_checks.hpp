#pragma once
/// @file Checks of names of outputs, before time is spent on what would go into them.

#include <string>
#include <vector>

#include "lumesh/core/error.hpp"

namespace lumesh::io {

/// @throws Error{kBadInput} if a folder does not exist or cannot be written to, or a name is that of a folder
/// or of a link to a file of another kind; Error of the other kind if two outputs are the same file.
void check_output_folders(const std::vector<std::string>& outputs, ErrorKind twice);

/// @param inputs  Files, and folders of which all files are read; empty names are none.
/// @throws Error of this kind if an output would replace an input.
void check_inputs_stay(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                       ErrorKind kind);

}  // namespace lumesh::io
