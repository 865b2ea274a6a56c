#include "case_words.hpp"

#include <algorithm>
#include <cctype>

#include "case_keys.hpp"

namespace lumesh::pipeline {
namespace {

/// "[lattice] max_tetrahedra" for "max-tetrahedra"; empty where no key has that name.
std::string key_of(std::string option, const std::vector<std::string>& sections) {
  std::replace(option.begin(), option.end(), '-', '_');
  Case any;
  const std::vector<Key> keys = keys_of(any);
  const auto rank = [&](const Key& key) { return std::find(sections.begin(), sections.end(), key.section); };
  const Key* best = nullptr;
  for (const Key& key : keys)
    if ((key.name == option || key.alias == option) && (best == nullptr || rank(key) < rank(*best)))
      best = &key;
  return best == nullptr || best->section.empty() ? "" : "[" + best->section + "] " + best->name;
}

bool is_of_a_name(char c) {
  return c == '-' || std::isalnum(static_cast<unsigned char>(c)) != 0;
}

}  // namespace

std::string in_case_words(const std::string& text, const std::vector<std::string>& sections) {
  std::string said;
  for (std::size_t at = 0; at < text.size();) {
    const auto name = text.begin() + static_cast<std::ptrdiff_t>(std::min(at + 2, text.size()));
    const auto end = std::find_if_not(name, text.end(), is_of_a_name);
    const std::string key = text.compare(at, 2, "--") == 0 ? key_of({name, end}, sections) : "";
    if (key.empty()) {
      said += text[at++];
      continue;
    }
    said += key;
    at = static_cast<std::size_t>(end - text.begin());
  }
  return said;
}

}  // namespace lumesh::pipeline
