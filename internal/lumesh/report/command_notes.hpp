#pragma once
/// @file How a command went besides its figures.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh::report {

/// Words for files that several commands and cases write.
inline constexpr const char *kMeshWords = "the mesh, with labels and patches",
                            *kCenterlineWords = "the centerline with its radius";

/// Part of the JSON of every command that makes or changes something.
struct CommandNotes {
  std::vector<OutputFile> files;      ///< Files written; one without a path was not wanted.
  std::vector<std::string> warnings;  ///< Texts as they were said.
  double seconds = 0;                 ///< Wall time of the command so far.
  std::vector<PhaseTime> phases;      ///< Its steps.
};

}  // namespace lumesh::report
