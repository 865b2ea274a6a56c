#include "foam_fields.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/io/text_file.hpp"

namespace lumesh {

namespace fs = std::filesystem;

namespace {

/// Without comments.
std::string bare(std::string text) {
  for (const auto& [begin, end] : {std::pair{"/*", "*/"}, std::pair{"//", "\n"}})
    for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
      const std::size_t behind = text.find(end, at + 2);
      text.erase(at, behind == std::string::npos ? behind : behind + (*end == '\n' ? 0 : 2) - at);
    }
  return text;
}

/// Names of the entries of `boundaryField`; none if there is no such list, or one with patterns or
/// directives.
std::optional<std::set<std::string>> entries_of(const std::string& text) {
  constexpr std::string_view kList = "boundaryField", kSpecial = "\"#$";
  std::size_t at = text.find(kList);
  if (at == std::string::npos || (at = text.find('{', at)) == std::string::npos) return std::nullopt;
  std::set<std::string> entries;
  std::string word;
  int depth = 1;
  for (++at; at < text.size() && depth > 0; ++at) {
    const char c = text[at];
    if (c == '{') {
      if (depth == 1) entries.insert(word);
      ++depth;
    } else if (c == '}') {
      --depth;
    } else if (depth == 1 && kSpecial.find(c) != std::string_view::npos) {
      return std::nullopt;
    } else if (depth == 1 && std::isspace(static_cast<unsigned char>(c)) == 0) {
      word += c;
      continue;
    } else if (depth == 1) {
      continue;
    }
    word.clear();
  }
  if (depth > 0) return std::nullopt;
  return entries;
}

/// Regular files of a folder by name.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
    if (entry.is_regular_file(none)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::optional<std::set<std::string>> entries_in(const fs::path& file) {
  constexpr std::uintmax_t kMostBytes = 10'000'000;  // Files of values at each cell are larger.
  std::error_code none;
  if (fs::file_size(file, none) > kMostBytes || none) return std::nullopt;
  try {
    return entries_of(bare(read_text_file(file)));
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::string stale_fields_text(const fs::path& foam_file, std::span<const FoamPatch> patches) {
  std::vector<std::string> files, missing, extra;
  const auto note = [](std::vector<std::string>& names, const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const fs::path& file : files_in(foam_file.parent_path() / "0")) {
    const std::optional<std::set<std::string>> entries = entries_in(file);
    if (!entries) continue;
    bool is_complete = true;
    for (const FoamPatch& patch : patches) {
      if (entries->contains(patch.name) || (!patch.group.empty() && entries->contains(patch.group))) continue;
      note(missing, patch.name), is_complete = false;
    }
    if (is_complete) continue;
    files.push_back("0/" + file.filename().string());
    for (const std::string& entry : *entries)
      if (std::ranges::none_of(patches,
                               [&](const FoamPatch& p) { return p.name == entry || p.group == entry; }))
        note(extra, entry);
  }
  if (files.empty()) return "";
  return fmt::format(
      "{} {} no entry for {}{}: solvers stop at that; change the names there", fmt::join(files, ", "),
      files.size() == 1 ? "has" : "have", fmt::join(missing, ", "),
      extra.empty() ? "" : fmt::format(", but for {}, which no patch has", fmt::join(extra, ", ")));
}

}  // namespace lumesh
