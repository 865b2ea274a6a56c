#pragma once
/// @file Options that are numbers within bounds.

#include <sstream>

#include "lumesh/core/error.hpp"

namespace lumesh {

/// @throws Error{kUsage} that names the option, unless least <= value <= most.
inline void check_range(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  std::ostringstream text;
  text << name << " must lie between " << least << " and " << most << ", not at " << value;
  throw Error(ErrorKind::kUsage, text.str());
}

}  // namespace lumesh
