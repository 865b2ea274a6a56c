#pragma once
/// @file What stages left, kept on disk with a key of all that it depends on.

#include <filesystem>
#include <map>
#include <string>

#include "case_stage.hpp"
#include "case_state.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh::pipeline {

class Checkpoints {
 public:
  /// @param folder  Made where something is to be kept; empty: nothing is.
  Checkpoints(std::filesystem::path folder, bool resumes) : folder_(std::move(folder)), resumes_(resumes) {}

  /// Whether what `stage` left is there under this key, as far as it is to be used.
  [[nodiscard]] bool has(CaseStage stage, const std::string& key) const;

  /// The centerline or the mesh, and what the stage said of itself.
  void keep(CaseStage stage, const CaseState& state, const report::StageReport& report,
            const std::string& key) const;
  /// @throws Error{kBadInput} if a file is broken.
  void load(CaseStage stage, CaseState& state, report::StageReport& report) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(CaseStage stage) const;

  std::filesystem::path folder_;
  bool resumes_;
};

/// Keys of all stages but the input: equal keys stand for equal results.
[[nodiscard]] std::map<CaseStage, std::string> stage_keys(const CaseState& state);

}  // namespace lumesh::pipeline
