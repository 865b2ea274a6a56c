#include <fmt/core.h>

#include "case_sections.hpp"
#include "lumesh/core/joined.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/io/file_formats.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// As TOML wants it. Single quotes hold anything but themselves and line ends.
std::string toml_text(const std::string& text) {
  if (text.find_first_of("'\n\r\t") == std::string::npos) return "'" + text + "'";
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') escaped += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      escaped += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      escaped += c;
  }
  return '"' + escaped + '"';
}

/// The shortest text that reads as the same number.
std::string number(double value) {
  return fmt::format("{}", value);
}

template <class Items, class Text>
std::string list_of(const Items& items, const Text& text) {
  return "[" + joined(items, text) + "]";
}

/// Empty for what has no value. Zero stands for what is not given (Option::zero).
struct ValueText {
  const Option& option;

  std::string operator()(const bool* v) const { return *v ? "true" : "false"; }
  std::string operator()(const std::string* v) const { return toml_text(*v); }
  std::string operator()(const OptionLabels& labels) const {
    return list_of(*labels.words,
                   [](const std::string& word) { return parse_number<int>(word) ? word : toml_text(word); });
  }
  std::string operator()(const std::vector<std::string>* v) const { return list_of(*v, toml_text); }
  std::string operator()(const std::map<int, double>* v) const {
    return list_of(*v, [](const auto& pair) { return fmt::format("'{}={}'", pair.first, pair.second); });
  }
  std::string operator()(const OptionWord& word) const { return toml_text(word.words[word.get()]); }
  std::string operator()(const OptionPath& file) const { return toml_text(*file.path); }
  std::string operator()(const OptionParsed& parsed) const { return toml_text(parsed.get()); }
  std::string operator()(const OptionLabelledFiles& labelled) const {
    return list_of(*labelled.files,
                   [](const auto& file) { return toml_text(fmt::format("{}={}", file.first, file.second)); });
  }
  std::string operator()(const OptionRows& rows) const {
    const auto row_text = [](const std::vector<double>& row) { return list_of(row, number); };
    const std::vector<std::vector<double>> values = rows.get();
    if (rows.is_single && values.empty()) return "";
    return rows.is_single ? row_text(values.front()) : list_of(values, row_text);
  }
  std::string operator()(const auto* /*number*/) const {
    const std::optional<double> value = option.number();
    return value ? number(*value) : "";
  }
};

/// What a key means, as a comment behind it.
std::string comment_of(const Option& key) {
  const std::string values = key.domain_text();
  return meaning_of(key) + (values.empty() ? "" : "; " + values) +
         (key.zero_text ? "; 0: " + *key.zero_text : "");
}

}  // namespace

std::string section_text(const Case& wanted, const std::string& section) {
  Case c = wanted;
  std::string text;
  for (const CaseSection& one : sections_of(c)) {
    if (one.name != section) continue;
    for (const Option& key : one.options.all()) {
      const std::string value = std::visit(ValueText{key}, key.target);
      const std::string line =
          value.empty() ? fmt::format("# {} =", key.name) : fmt::format("{} = {}", key.name, value);
      text += fmt::format("{:<32} # {}\n", line, comment_of(key));
    }
  }
  return text;
}

}  // namespace pipeline

std::string case_text(const Case& wanted) {
  Case c = wanted;
  std::string text;
  for (const CaseSection& section : sections_of(c)) {
    if (!section.name.empty()) text += fmt::format("\n[{}]  # {}\n", section.name, section.meaning);
    text += pipeline::section_text(wanted, section.name);
  }
  return text;
}

}  // namespace lumesh
