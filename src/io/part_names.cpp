#include "part_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_words.hpp"

namespace lumesh::io {
namespace {

/// Whether all that told people one name from another is lost, as of one in Chinese with a number behind it.
bool is_word_without_letters(const std::string& word, const std::string& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_foreign = [](char c) { return static_cast<unsigned char>(c) >= 0x80; };
  return std::ranges::none_of(word, is_letter) && (word.empty() || std::ranges::any_of(name, is_foreign));
}

}  // namespace

std::string name_patches_by_words(std::vector<Patch>& patches, std::string_view otherwise) {
  std::vector<Patch> named;
  std::vector<std::pair<std::string, std::string>> changed;
  for (const Patch& patch : patches) {
    const std::string word = patch_word(patch.name);
    const bool is_lost = is_word_without_letters(word, patch.name);
    const std::string name =
        free_patch_name(named, is_lost ? fmt::format("{}_{}", otherwise, named.size() + 1) : word);
    if (name != patch.name) changed.emplace_back(patch.name, name);
    named.push_back({name, kind_of_name(name), {}});
  }
  patches = std::move(named);
  return changed_names_text(changed);
}

}  // namespace lumesh::io
