#pragma once
/// @file Names as OpenFOAM's dictionaries take them.

#include <set>
#include <string>

namespace lumesh::io {

/// The names of one list, each once. OpenFOAM splits names at blanks, quotes, brackets and semicolons,
/// expands those with $ or #, and reads what begins with a digit or sign as a number.
class FoamWords {
 public:
  /// The name with '_' for what may not stand in it, and a number behind it if it is there already.
  const std::string& add(std::string name) {
    for (char& c : name)
      if (!is_letter(c) && !is_inner(c)) c = '_';
    if (name.empty() || !is_letter(name.front())) name.insert(name.begin(), '_');
    std::string word = name;
    for (int number = 2; words_.contains(word); ++number) word = name + '_' + std::to_string(number);
    return *words_.insert(word).first;
  }
  [[nodiscard]] bool contains(const std::string& word) const { return words_.contains(word); }

 private:
  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool is_inner(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.'; }

  std::set<std::string> words_;
};

}  // namespace lumesh::io
