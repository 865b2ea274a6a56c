#pragma once
/// @file An evaluation as text for the terminal and as JSON for programs.

#include <string>

#include "lumesh/domain/openings.hpp"
#include "lumesh/quality/evaluation.hpp"

namespace lumesh::report {

/// A compact table of an evaluation, lines of at most 100 columns, UTF-8.
[[nodiscard]] std::string summary_text(const quality::Evaluation& evaluation);

/// The evaluation as JSON; docs/stages/evaluate.md describes the fields. Numbers that are infinite become
/// null.
[[nodiscard]] std::string evaluation_json(const quality::Evaluation& evaluation);

/// Its field "openings" alone.
[[nodiscard]] std::string openings_json(const OpeningsCompared& openings);

}  // namespace lumesh::report
