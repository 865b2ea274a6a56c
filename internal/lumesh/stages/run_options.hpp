#pragma once
/// @file Options of how a command or a case runs, and of what both write of it, described once for the two.

#include <string>
#include <vector>

#include "lumesh/core/option.hpp"

namespace lumesh {

/// Threads; 0: all cores.
Option& describe_threads(OptionList& list, int& threads);
/// Time limit in seconds; infinite: none.
void describe_time_limit(OptionList& list, double& limit_s);
/// Names for patches, texts for renaming_from().
void describe_names(OptionList& list, std::vector<std::string>& names);
/// Page with what is known of a mesh.
void describe_report(OptionList& list, std::string& path);

}  // namespace lumesh
