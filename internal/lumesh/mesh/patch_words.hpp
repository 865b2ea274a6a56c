#pragma once
/// @file Names as every solver takes them, in patches, zones and files alike.

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// The text as a part of a name that solvers take: one '_' for other characters than letters, digits, '_',
/// '-' and '.' that follow each other, none for those at its ends or beside a '_'. Letters are those of
/// ASCII. Empty if nothing is left.
[[nodiscard]] std::string patch_word(std::string_view text);

/// The names of one list, each once: OpenFOAM's dictionaries and SimVascular's files.
class PatchWords {
 public:
  /// patch_word() of the name without '-' and '.' at its front, or of the other if that is empty; with '_'
  /// before a digit, which begins a number, and with a number behind it, _2, …, if it is there already.
  const std::string& add(std::string_view name, std::string_view otherwise);
  [[nodiscard]] bool contains(const std::string& word) const { return words_.contains(word); }

 private:
  std::set<std::string> words_;
};

/// Text that tells which names of patches became which words, the first dozen of them; empty for none.
/// @param changed  Names and their words.
[[nodiscard]] std::string changed_names_text(const std::vector<std::pair<std::string, std::string>>& changed);

/// What labels are called within the names of patches and zones: patch_word() of their names, with _2, …
/// behind the second one, … of equal ones. It depends on the names alone, not on which of them a mesh has.
/// Labels whose words would be taken for something else (numbers, label_7, rim_1 of wall_rim_1) have none.
[[nodiscard]] std::map<Label, std::string> label_words(const std::map<Label, std::string>& label_names);

}  // namespace lumesh
