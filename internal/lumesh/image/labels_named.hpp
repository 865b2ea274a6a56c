#pragma once
/// @file Values that options give for single labels.

#include <map>
#include <span>
#include <string>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Refuses a value for a label that is not among those that can be meshed.
/// @param option  As option_name() spells it. @param present  Labels without the background, ascending.
/// @throws Error{kBadInput} that names the option, and the first of these labels.
void require_labels(const std::string& option, const std::map<Label, double>& values,
                    std::span<const Label> present);

}  // namespace lumesh
