#pragma once
/// @file What stages say of the program's options, in the words of a case file.

#include <string>
#include <vector>

namespace lumesh::pipeline {

/// The text with every "--max-tetrahedra" as "[lattice] max_tetrahedra".
/// @param sections  Where to look first for a key of that name, such as {"lattice", "input"}.
[[nodiscard]] std::string in_case_words(const std::string& text, const std::vector<std::string>& sections);

}  // namespace lumesh::pipeline
