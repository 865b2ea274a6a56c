#pragma once
/// @file What a misspelt word may have been meant to be.

#include <string>
#include <vector>

namespace lumesh {

/// The word of `known` most like a wrong one, empty if none is alike.
[[nodiscard]] std::string nearest_word(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace lumesh
