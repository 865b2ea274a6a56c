#pragma once
/// @file What the readers and writers of case files share.

#include <set>
#include <string>
#include <vector>

#include "lumesh/pipeline/pipeline.hpp"

namespace lumesh::pipeline {

/// The lines of one section, without its head.
[[nodiscard]] std::string section_text(const Case& wanted, const std::string& section);

/// "[lattice] spacing" for an option of the sections, the first that has it; "" where none has.
[[nodiscard]] std::string key_called(std::string_view option, const std::vector<std::string>& sections);

/// A message of a stage with the names of options as case files have them.
/// @param sections  Of the stage; options of others are looked for after these. @param size_key  Key for
/// options of the size of edges, if not empty: size_key_of() the case.
[[nodiscard]] std::string with_case_keys(const std::string& message, const std::vector<std::string>& sections,
                                         const std::string& size_key = {});

/// The key of a case for the edges of the first mesh: the one that is given, else "edge_length".
[[nodiscard]] std::string size_key_of(const Case& c);

/// A file that a case reads.
struct CaseFileRead {
  std::string key;  ///< "[metric] points".
  std::string path;
};
[[nodiscard]] std::vector<CaseFileRead> files_read_by(const Case& c);

/// Refuses keys that contradict one another.
/// @param given  "section.name" of all keys that the file or the command line give.
/// @throws Error{kBadInput} that does not name the file.
void check_case(const Case& c, const std::set<std::string>& given);

}  // namespace lumesh::pipeline
