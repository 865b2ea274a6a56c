#pragma once
/// @file The whole way from an image to the adapted mesh, in memory (the paper's figure 1).

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/pipeline/case.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh {

struct CaseResult {
  report::CaseReport report;
  std::string folder;                     ///< Folder of the files.
  std::vector<std::string> faults;        ///< Faults of the mesh that was written (quality::find_faults()).
  std::vector<std::string> without_name;  ///< A line for each name of the case whose patch the mesh lacks.
  bool complete = true;  ///< False if the context was cancelled: files hold the best mesh so far.

  /// A line on time and memory.
  [[nodiscard]] std::string text() const;
  /// @param besides  What else has to be said then.
  /// @throws Error{kNotReached} if the mesh is invalid, layers are hardly there, or a patch with a name by
  /// the case is missing.
  void require_good(const std::string& besides) const;
};

/// Runs the stages that the case asks for, one after the other: input, centerline, first mesh, metric,
/// adapted mesh, its measures; then writes the files: meshes, report, numbers, and the case with every
/// setting that was in force. Each stage says one line to context.info() when it is done.
///
/// With checkpoints, what each stage leaves is kept in the folder `checkpoints`, with a key made of all that
/// it depends on: contents of files, settings, the version. A run that resumes has a bitwise identical
/// result.
/// @throws Error as the stages do; files are written beside their targets and renamed when complete.
[[nodiscard]] CaseResult run_case(const Case& c, Context& context);

/// The case itself, or, where all frames of its image are wanted, a case for each, with a folder of its own
/// in that of the case. @throws Error{kBadInput} as count_frames().
[[nodiscard]] std::vector<Case> cases_of_frames(const Case& c);

/// Predicted steps of a case, and about what they will take.
struct CasePrediction {
  struct Step {
    std::string what;       ///< One line.
    double seconds = 0;     ///< Wall time, 0 where next to none.
    double tetrahedra = 0;  ///< Number in the mesh it leaves; 0: none, or not known.
  };
  std::vector<Step> steps;
  double peak_memory_bytes = 0;
  std::uint64_t free_memory_bytes = 0;

  [[nodiscard]] double seconds() const;
  /// A line for each step, and one on the whole.
  [[nodiscard]] std::string text() const;
};

/// Reads the input and samples the metric's sources at voxels; makes no mesh and writes nothing. How far
/// numbers of tetrahedra and times are to be trusted: docs/stages/run.md, "What a dry run knows".
/// @throws Error as run_case() does for its input.
[[nodiscard]] CasePrediction predict_case(const Case& c, Context& context);

}  // namespace lumesh
