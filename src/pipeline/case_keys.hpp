#pragma once
/// @file The keys of a case file, each once: reading, writing and checking go by this list.

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lumesh/pipeline/case.hpp"

namespace lumesh::pipeline {

/// One word of several; the place of a word in the list is its number.
struct Choice {
  std::vector<std::string> words;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

/// A file of the user's. Relative to the case file, but for the words that are no files.
struct FilePath {
  std::string* path;
  std::vector<std::string> words;
};

using KeyTarget = std::variant<bool*, int*, std::size_t*, double*, std::optional<double>*, std::string*,
                               std::vector<int>*, std::vector<std::string>*, std::vector<CutPlane>*,
                               std::vector<Vec3>*, Index3*, Vec3*, Choice, FilePath>;

struct Key {
  std::string section;  ///< Empty: before the first one.
  std::string name;
  std::string alias;  ///< Another name, mostly the paper's; may be empty.
  KeyTarget target;
  double least, most;  ///< Of numbers.
  std::string meaning;
};

/// All keys of a case, section by section. They point into `c`, which has to live longer.
[[nodiscard]] std::vector<Key> keys_of(Case& c);

/// What a section is about.
[[nodiscard]] std::string section_meaning(const std::string& section);

/// The lines of one section, without its head.
[[nodiscard]] std::string section_text(const Case& wanted, const std::string& section);

/// Refuses keys that contradict one another. @throws Error{kBadInput} that does not name the file.
void check_case(const Case& c);

}  // namespace lumesh::pipeline
