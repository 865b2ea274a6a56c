#pragma once
// Names that files of surfaces give solids and groups, which may be any text.

#include <string>
#include <string_view>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// Spaces, tabs and ends of lines, which may stand around a name.
inline constexpr std::string_view kSpaces = " \t\r\n";

/// Calls patches by patch_word() of their names, and gives them the kind that it says. Different names stay
/// different, a_b and a_b_2; one of which no letter is left becomes `otherwise` with its number.
/// @return A line that says which names became what; empty where none changed.
[[nodiscard]] std::string name_patches_by_words(std::vector<Patch>& patches, std::string_view otherwise);

}  // namespace lumesh::io
