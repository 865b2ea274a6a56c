#pragma once
/// @file The stages of a run, and how each is called where.

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/pipeline/pipeline.hpp"

namespace lumesh::pipeline {

/// In the order of a run.
enum class CaseStage : std::uint8_t { kInput, kCenterline, kMesh, kMetric, kAdapted, kLayers };

struct CaseStageNames {
  const char* word;     ///< In progress lines, keys and names of checkpoints.
  const char* title;    ///< Heading in reports.
  const char* section;  ///< Section of case files that it goes by; nullptr: that of the case's mesher.
};
[[nodiscard]] const CaseStageNames& names_of(CaseStage stage);

/// Section of case files that a mesher goes by.
[[nodiscard]] const char* section_of(Mesher mesher);
/// Sections of case files that a stage goes by, its own first.
[[nodiscard]] std::vector<std::string> sections_of(CaseStage stage, Mesher mesher);

}  // namespace lumesh::pipeline
