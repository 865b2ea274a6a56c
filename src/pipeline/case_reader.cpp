#include <fmt/core.h>

#include <stdexcept>
// The parser asserts what a text may break, such as "[.a]": an exception instead.
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : throw std::logic_error("unexpected character"))
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wterminate"
#include <toml++/toml.h>
#pragma GCC diagnostic pop

#include <set>
#include <sstream>

#include "case_sections.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/nearest_word.hpp"
#include "lumesh/core/option_words.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/io/text_file.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// One file, or one setting of the command line, as a source of values.
class CaseReader {
 public:
  /// @param has_lines  False for a single line, whose number says nothing.
  /// @param given  Gets "section.name" of each key.
  CaseReader(std::string name, bool has_lines, std::filesystem::path folder, std::set<std::string>& given)
      : name_(std::move(name)), has_lines_(has_lines), folder_(std::move(folder)), given_(given) {}

  void read(const std::string& text, const std::vector<CaseSection>& sections) {
    const toml::table table = parsed(text);
    check_sections(table, sections);
    for (const CaseSection& section : sections) {
      const toml::table* const part = section.name.empty() ? &table : table[section.name].as_table();
      if (part == nullptr) continue;
      for (const Option& key : section.options.all()) {
        const toml::node* node = part->get(key.name);
        for (const std::string& alias : key.aliases)
          if (node == nullptr) node = part->get(alias);
        if (node == nullptr) continue;
        take({section, key}, *node);
        given_.insert(section.name + "." + key.name);
      }
    }
  }

 private:
  /// A key with its section, for messages.
  struct Key {
    const CaseSection& section;
    const Option& option;

    [[nodiscard]] std::string full_name() const {
      return section.name.empty() ? option.name : fmt::format("[{}] {}", section.name, option.name);
    }
  };

  [[noreturn]] void throw_bad_entry(const toml::source_region& where, const std::string& what) const {
    const std::string line = has_lines_ ? fmt::format(":{}", where.begin.line) : "";
    throw Error(ErrorKind::kBadInput, fmt::format("{}{}: {}", name_, line, what));
  }
  [[noreturn]] void throw_bad_entry(const Key& key, const toml::node& node, const std::string& what) const {
    throw_bad_entry(node.source(), fmt::format("{} {}", key.full_name(), what));
  }

  [[nodiscard]] toml::table parsed(const std::string& text) const {
    try {
      return toml::parse(text, name_);
    } catch (const toml::parse_error& error) {
      std::string what(error.description());
      if (what.find("determine value type") != std::string::npos) what += "; texts stand in quotes";
      throw_bad_entry(error.source(), what);
    } catch (const std::logic_error& broken) {
      throw Error(ErrorKind::kBadInput, fmt::format("{}: is no TOML ({})", name_, broken.what()));
    }
  }

  void check_sections(const toml::table& table, const std::vector<CaseSection>& sections) const {
    std::vector<std::string> first_words;
    for (const CaseSection& section : sections)
      if (!section.name.empty()) first_words.push_back(section.name);
    for (const Option& key : sections.front().options.all()) first_words.push_back(key.name);
    for (const auto& [word, node] : table) {
      const std::string name(word.str());
      const auto section = std::find_if(sections.begin() + 1, sections.end(),
                                        [&](const CaseSection& one) { return one.name == name; });
      if (section != sections.end() && !node.is_table())
        throw_bad_entry(node.source(),
                        fmt::format("{} is a section; write [{}] in a line of its own", name, name));
      if (section != sections.end())
        check_keys(*section, *node.as_table());
      else if (std::ranges::find(first_words, name) == first_words.end())
        throw_bad_entry(word.source(), unknown(node.is_table() ? "section" : "key", name, first_words, ""));
    }
  }
  void check_keys(const CaseSection& section, const toml::table& table) const {
    std::vector<std::string> known;
    for (const Option& key : section.options.all()) {
      known.push_back(key.name);
      known.insert(known.end(), key.aliases.begin(), key.aliases.end());
    }
    for (const auto& [word, node] : table)
      if (std::ranges::find(known, word.str()) == known.end())
        throw_bad_entry(word.source(), unknown("key", std::string(word.str()), known,
                                               fmt::format(" in [{}]", section.name)));
    for (const Option& key : section.options.all())
      for (const std::string& alias : key.aliases)
        if (table.contains(key.name) && table.contains(alias))
          throw_bad_entry(table.get(alias)->source(),
                          fmt::format("{} is another name of {}, which is given, too; leave one out", alias,
                                      Key{section, key}.full_name()));
  }
  static std::string unknown(const std::string& kind, const std::string& name,
                             const std::vector<std::string>& known, const std::string& where) {
    std::string message = fmt::format("unknown {} \"{}\"{}", kind, name, where);
    const std::string nearest = nearest_word(name, known);
    if (!nearest.empty()) return message + fmt::format("; did you mean \"{}\"?", nearest);
    message += "; known:";
    for (const std::string& word : known) message += " " + word;
    return message;
  }

  [[nodiscard]] double number_of(const Key& key, const toml::node& node) const {
    const std::optional<double> number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number) throw_bad_entry(key, node, "must be a number");
    const std::string complaint = key.option.complaint(*number);
    if (!complaint.empty()) throw_bad_entry(key, node, complaint);
    return *number;
  }
  template <class Integer>
  [[nodiscard]] Integer integer_of(const Key& key, const toml::node& node) const {
    if (!node.is_integer()) throw_bad_entry(key, node, "must be a whole number");
    const double number = number_of(key, node);
    if (number < static_cast<double>(std::numeric_limits<Integer>::min()) ||
        number > static_cast<double>(std::numeric_limits<Integer>::max()))
      throw_bad_entry(key, node, fmt::format("is too large a number: {:g}", number));
    return static_cast<Integer>(number);
  }
  /// A whole number is taken as its digits: labels have numbers and names, and the paper writes some words as
  /// numbers.
  [[nodiscard]] std::string text_of(const Key& key, const toml::node& node) const {
    if (const std::optional<std::int64_t> number =
            node.is_integer() ? node.value<std::int64_t>() : std::nullopt)
      return std::to_string(*number);
    const std::optional<std::string> text = node.is_string() ? node.value<std::string>() : std::nullopt;
    if (!text) throw_bad_entry(key, node, "must be a text in quotes");
    return *text;
  }
  [[nodiscard]] const toml::array& array_of(const Key& key, const toml::node& node, std::size_t count,
                                            const std::string& wanted) const {
    const toml::array* const array = node.as_array();
    if (array == nullptr || (count > 0 && array->size() != count))
      throw_bad_entry(key, node, fmt::format("must be {}", wanted));
    return *array;
  }
  /// One row of numbers, as a list or, as on the command line, as a text.
  [[nodiscard]] std::vector<double> row_of(const Key& key, const toml::node& node, const OptionRows& rows,
                                           const std::string& wanted) const {
    std::vector<double> row;
    if (node.is_string()) {
      row = rows.row_from(*node.value<std::string>()).value_or(row);
      for (const double number : row)
        if (const std::string complaint = key.option.complaint(number); !complaint.empty())
          throw_bad_entry(key, node, complaint);
    } else {
      for (const toml::node& number : array_of(key, node, 0, wanted)) row.push_back(number_of(key, number));
    }
    if (!rows.takes(row.size())) throw_bad_entry(key, node, fmt::format("must be {}", wanted));
    return row;
  }
  static bool is_one_row(const toml::node& node) {
    const toml::array* const array = node.as_array();
    return node.is_string() || (array != nullptr && !array->empty() && array->front().is_number());
  }

  template <class Set>
  void set_or_throw(const Key& key, const toml::node& node, const Set& set) const {
    try {
      set();
    } catch (const Error& senseless) {
      if (senseless.kind() != ErrorKind::kUsage) throw;  // Is a refusal of ours.
      throw_bad_entry(key, node, senseless.what());
    }
  }

  /// "none" is what the tables show for what is empty.
  void take(const Key& key, const toml::node& node) const {
    bool is_none = node.is_string() && *node.value<std::string>() == "none";
    if (is_none) set_or_throw(key, node, [&] { is_none = take_none(key.option); });
    if (is_none) return;
    std::visit([&](const auto& target) { set(key, node, target); }, key.option.target);
  }
  void set(const Key& key, const toml::node& node, bool* target) const {
    const std::optional<bool> value = node.is_boolean() ? node.value<bool>() : std::nullopt;
    if (!value) throw_bad_entry(key, node, "must be true or false");
    *target = *value;
  }
  void set(const Key& key, const toml::node& node, int* target) const {
    *target = integer_of<int>(key, node);
  }
  void set(const Key& key, const toml::node& node, std::size_t* target) const {
    *target = integer_of<std::size_t>(key, node);
  }
  void set(const Key& key, const toml::node& node, double* target) const {
    const double number = number_of(key, node);
    *target = number == 0 && key.option.zero_text ? key.option.zero_value : number;
  }
  void set(const Key& key, const toml::node& node, std::optional<double>* target) const {
    *target = number_of(key, node);
  }
  void set(const Key& key, const toml::node& node, std::string* target) const {
    *target = text_of(key, node);
  }
  void set(const Key& key, const toml::node& node, const OptionLabels& labels) const {
    labels.words->clear();
    for (const toml::node& item :
         array_of(key, node, 0, "a list of numbers or names of labels, such as [1, \"wall\"]"))
      labels.words->push_back(item.is_string() ? text_of(key, item)
                                               : std::to_string(integer_of<int>(key, item)));
  }
  void set(const Key& key, const toml::node& node, std::vector<std::string>* target) const {
    target->clear();
    if (node.is_string()) return target->push_back(text_of(key, node));  // A list of one.
    for (const toml::node& item : array_of(key, node, 0, "a list of texts, such as [\"mesh.vtu\"]"))
      target->push_back(text_of(key, item));
  }
  void set(const Key& key, const toml::node& node, std::map<int, double>* target) const {
    target->clear();
    for (const toml::node& item :
         array_of(key, node, 0, "a list of texts LABEL=NUMBER, such as [\"2=0.4\"]")) {
      const std::string text = text_of(key, item);
      const std::string complaint = add_label_number(text, key.option, *target);
      if (!complaint.empty()) throw_bad_entry(key, item, complaint);
    }
  }
  void set(const Key& key, const toml::node& node, const OptionLabelledFiles& labelled) const {
    labelled.files->clear();
    for (const toml::node& item :
         array_of(key, node, 0, "a list of texts FILE=LABEL, such as [\"wall.nrrd=2\"]")) {
      const std::string complaint = add_labelled_file(text_of(key, item), *labelled.files);
      if (!complaint.empty()) throw_bad_entry(key, item, complaint);
      std::string& path = labelled.files->back().first;
      path = std::filesystem::absolute(folder_ / path).lexically_normal().string();
    }
  }
  void set(const Key& key, const toml::node& node, const OptionRows& rows) const {
    std::vector<std::vector<double>> values;
    const std::string width = rows.width_text();
    const std::string wanted =
        fmt::format("{}{}, such as [{}]{}", rows.is_single ? "a number, or " : "", width, rows.example,
                    rows.is_single ? "" : ", or a list of such lists");
    if (rows.is_single && node.is_number())
      values.emplace_back(rows.least > 0 ? rows.least : rows.width, number_of(key, node));
    else if (rows.is_single || is_one_row(node))
      values.push_back(row_of(key, node, rows, wanted));
    else
      for (const toml::node& item : array_of(key, node, 0, wanted))
        values.push_back(row_of(key, item, rows, wanted));
    set_or_throw(key, node, [&] { rows.set(values); });
  }
  void set(const Key& key, const toml::node& node, const OptionParsed& parsed) const {
    set_or_throw(key, node, [&] { parsed.set(text_of(key, node)); });
  }
  void set(const Key& key, const toml::node& node, const OptionWord& word) const {
    const std::string text =
        node.is_boolean() ? (*node.value<bool>() ? "true" : "false") : text_of(key, node);
    const std::optional<std::size_t> index = word.index_of(text);
    if (!index) throw_bad_entry(key, node, word.complaint(text));
    word.set(*index);
  }
  void set(const Key& key, const toml::node& node, const OptionPath& file) const {
    *file.path = text_of(key, node);
    if (file.path->empty() || std::ranges::find(file.words, *file.path) != file.words.end()) return;
    *file.path = std::filesystem::absolute(folder_ / *file.path).lexically_normal().string();
  }

  std::string name_;
  bool has_lines_;
  std::filesystem::path folder_;
  std::set<std::string>& given_;
};

bool is_text(const OptionTarget& target) {
  return std::holds_alternative<std::string*>(target) || std::holds_alternative<OptionPath>(target) ||
         std::holds_alternative<OptionParsed>(target);
}

/// As a TOML string.
std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

/// "metric.k=40" as a line of TOML. Quotes are not asked for: what a key of a text gets, and what is no value
/// of TOML, is a text.
void read_setting(const std::string& setting, const std::vector<CaseSection>& sections,
                  std::set<std::string>& given) {
  const std::string how = "--set " + setting + ": write SECTION.KEY=VALUE, such as metric.k=40";
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) throw Error(ErrorKind::kUsage, how);
  const std::string name(trimmed(setting.substr(0, equals))), value(trimmed(setting.substr(equals + 1)));
  bool takes_text = false;
  for (const CaseSection& section : sections) {
    if (section.name == name) throw Error(ErrorKind::kUsage, how);
    for (const Option& key : section.options.all())
      if (name == (section.name.empty() ? key.name : section.name + "." + key.name))
        takes_text = is_text(key.target);
  }
  try {
    const toml::table table = toml::parse("value = " + value);
    takes_text = takes_text && !table["value"].is_string();
  } catch (const toml::parse_error&) {
    takes_text = true;
  }
  CaseReader("--set " + setting, false, std::filesystem::current_path(), given)
      .read(name + " = " + (takes_text ? quoted(value) : value), sections);
}

}  // namespace
}  // namespace pipeline

Case read_case(const std::filesystem::path& path, std::span<const std::string> settings) {
  Case c;
  c.name = path.stem().string();
  c.file = path.string();
  const std::vector<CaseSection> sections = sections_of(c);
  std::set<std::string> given;
  pipeline::CaseReader(c.file, true, path.parent_path(), given).read(read_text_file(path), sections);
  for (const std::string& setting : settings) pipeline::read_setting(setting, sections, given);
  naming(c.file, [&] { pipeline::check_case(c, given); });
  return c;
}

}  // namespace lumesh
