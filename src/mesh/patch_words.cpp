#include "lumesh/mesh/patch_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "lumesh/mesh/patch_list.hpp"

namespace lumesh {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_in_words(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' || c == '-' || c == '.';
}
bool is_number(std::string_view text) {
  return std::ranges::all_of(text, is_digit);
}

/// Words that stand for something else in names of patches.
bool is_reserved(const std::string& word, Label label) {
  constexpr std::string_view kLabel = "label_";
  const bool is_other_label = word.starts_with(kLabel) &&
                              is_number(std::string_view(word).substr(kLabel.size())) &&
                              word != std::string(kLabel) + std::to_string(label);
  return is_number(word) || is_other_label || is_rim_name("wall_" + word);
}

/// The word, or with the first number behind it that makes it a new one.
std::string free_word(const std::string& word, const std::set<std::string>& taken) {
  std::string free = word;
  for (int number = 2; taken.contains(free); ++number) free = word + "_" + std::to_string(number);
  return free;
}

}  // namespace

std::string patch_word(std::string_view text) {
  std::string word;
  bool leaves_out = false;
  for (const char c : text) {
    if (!is_in_words(c)) {
      leaves_out = true;
      continue;
    }
    if (leaves_out && !word.empty() && word.back() != '_' && c != '_') word += '_';
    leaves_out = false;
    word += c;
  }
  return word;
}

const std::string& PatchWords::add(std::string_view name, std::string_view otherwise) {
  std::string word = patch_word(name);
  word.erase(0, word.find_first_not_of("-."));
  if (word.empty()) word = patch_word(otherwise);
  if (word.empty() || is_digit(word.front())) word.insert(0, "_");
  return *words_.insert(free_word(word, words_)).first;
}

std::string changed_names_text(const std::vector<std::pair<std::string, std::string>>& changed) {
  if (changed.empty()) return "";
  constexpr std::size_t kMaxTold = 12;
  std::vector<std::string> told;
  for (const auto& [name, word] : std::span(changed).first(std::min(kMaxTold, changed.size())))
    told.push_back(fmt::format("\"{}\" is {}", name, word));
  if (changed.size() > kMaxTold) told.push_back(fmt::format("and {} more", changed.size() - kMaxTold));
  return fmt::format("names of patches keep ASCII's letters, digits and _ - . only: {}",
                     fmt::join(told, ", "));
}

std::map<Label, std::string> label_words(const std::map<Label, std::string>& label_names) {
  std::map<Label, std::string> words;
  std::set<std::string> taken;
  for (const auto& [label, name] : label_names) taken.insert(patch_word(name));
  std::set<std::string> given;
  for (const auto& [label, name] : label_names) {
    const std::string word = patch_word(name);
    if (is_reserved(word, label)) continue;
    // A number behind it must not make it the word of a name that is so from the first.
    const std::string own = given.contains(word) ? free_word(word, taken) : word;
    taken.insert(own);
    given.insert(own);
    words[label] = own;
  }
  return words;
}

}  // namespace lumesh
