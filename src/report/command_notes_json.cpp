#include "command_notes_json.hpp"

#include <map>
#include <utility>

namespace lumesh::report {

using NotesJson = nlohmann::ordered_json;

NotesJson steps_json(const CommandNotes& notes) {
  std::map<std::string, double> steps;
  for (const PhaseTime& phase : notes.phases) steps[phase.name] += phase.seconds;
  return steps;
}

std::string with_files_and_warnings(NotesJson figures, const CommandNotes& notes) {
  figures["files"] = NotesJson::array();
  for (const OutputFile& file : notes.files)
    if (!file.path.empty()) figures["files"].push_back({{"path", file.path}, {"what", file.what}});
  figures["warnings"] = notes.warnings;
  // Names of files may be in any encoding.
  return figures.dump(2, ' ', false, NotesJson::error_handler_t::replace) + "\n";
}

std::string with_notes(NotesJson figures, const CommandNotes& notes) {
  figures["seconds"] = notes.seconds;
  figures["seconds_by_step"] = steps_json(notes);
  return with_files_and_warnings(std::move(figures), notes);
}

}  // namespace lumesh::report
