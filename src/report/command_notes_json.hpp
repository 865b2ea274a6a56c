#pragma once
// Notes on commands as JSON.

#include <nlohmann/json.hpp>
#include <string>

#include "lumesh/report/command_notes.hpp"

namespace lumesh::report {

/// Times of the steps by name; those of one name together.
[[nodiscard]] nlohmann::ordered_json steps_json(const CommandNotes& notes);
/// The text of a command's JSON: its figures with files and warnings behind them.
[[nodiscard]] std::string with_files_and_warnings(nlohmann::ordered_json figures, const CommandNotes& notes);
/// The same with `seconds` and `seconds_by_step` before these.
[[nodiscard]] std::string with_notes(nlohmann::ordered_json figures, const CommandNotes& notes);

}  // namespace lumesh::report
