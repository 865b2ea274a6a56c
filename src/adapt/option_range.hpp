#pragma once
/// @file Options that are numbers within bounds.

#include <string>

#include "lumesh/core/error.hpp"

namespace lumesh {

/// @throws Error{kUsage} that names the option, unless least <= value <= most.
inline void check_range(const char* name, double value, double least, double most) {
  if (!(value >= least && value <= most))
    throw Error(ErrorKind::kUsage, std::string(name) + " must lie between " + std::to_string(least) +
                                       " and " + std::to_string(most));
}

}  // namespace lumesh
