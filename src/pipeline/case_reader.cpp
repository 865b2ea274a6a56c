#include <fmt/core.h>

#include <stdexcept>
// The parser asserts what a text may break, such as "[.a]": an exception instead.
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : throw std::logic_error("unexpected character"))
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wterminate"
#include <toml++/toml.h>
#pragma GCC diagnostic pop

#include <cmath>
#include <set>
#include <sstream>

#include "case_keys.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/nearest_word.hpp"
#include "lumesh/io/text_file.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// One file, or one setting of the command line, as a source of values.
class CaseReader {
 public:
  /// @param has_lines  False for a single line, whose number says nothing.
  CaseReader(std::string name, bool has_lines, std::filesystem::path folder)
      : name_(std::move(name)), has_lines_(has_lines), folder_(std::move(folder)) {}

  void read(const std::string& text, const std::vector<Key>& keys) {
    const toml::table table = parsed(text);
    refuse_unknown(table, keys);
    for (const Key& key : keys) {
      const toml::table* const section = key.section.empty() ? &table : table[key.section].as_table();
      if (section == nullptr) continue;
      const toml::node* node = section->get(key.name);
      if (node == nullptr && !key.alias.empty()) node = section->get(key.alias);
      if (node != nullptr) take(key, *node);
    }
  }

 private:
  [[noreturn]] void refuse(const toml::source_region& where, const std::string& what) const {
    const std::string line = has_lines_ ? fmt::format(":{}", where.begin.line) : "";
    throw Error(ErrorKind::kBadInput, fmt::format("{}{}: {}", name_, line, what));
  }
  [[noreturn]] void refuse(const Key& key, const toml::node& node, const std::string& what) const {
    refuse(node.source(), fmt::format("{} {}", full_name(key), what));
  }
  static std::string full_name(const Key& key) {
    return key.section.empty() ? key.name : fmt::format("[{}] {}", key.section, key.name);
  }

  [[nodiscard]] toml::table parsed(const std::string& text) const {
    try {
      return toml::parse(text, name_);
    } catch (const toml::parse_error& error) {
      refuse(error.source(), std::string(error.description()));
    } catch (const std::logic_error& broken) {
      throw Error(ErrorKind::kBadInput, fmt::format("{}: is no TOML ({})", name_, broken.what()));
    }
  }

  void refuse_unknown(const toml::table& table, const std::vector<Key>& keys) const {
    std::vector<std::string> sections, in_front;
    for (const Key& key : keys) {
      if (key.section.empty())
        in_front.push_back(key.name);
      else if (sections.empty() || sections.back() != key.section)
        sections.push_back(key.section);
    }
    std::vector<std::string> first_words = sections;
    first_words.insert(first_words.end(), in_front.begin(), in_front.end());
    for (const auto& [word, node] : table) {
      const std::string name(word.str());
      const bool is_section = std::find(sections.begin(), sections.end(), name) != sections.end();
      if (is_section && !node.is_table())
        refuse(node.source(), fmt::format("{} is a section; write [{}] in a line of its own", name, name));
      if (is_section)
        refuse_unknown_in(name, *node.as_table(), keys);
      else if (std::find(in_front.begin(), in_front.end(), name) == in_front.end())
        refuse(word.source(), unknown(node.is_table() ? "section" : "key", name, first_words, ""));
    }
  }
  void refuse_unknown_in(const std::string& section, const toml::table& table,
                         const std::vector<Key>& keys) const {
    std::vector<std::string> known;
    for (const Key& key : keys)
      if (key.section == section) {
        known.push_back(key.name);
        if (!key.alias.empty()) known.push_back(key.alias);
      }
    for (const auto& [word, node] : table)
      if (std::find(known.begin(), known.end(), word.str()) == known.end())
        refuse(word.source(),
               unknown("key", std::string(word.str()), known, fmt::format(" in [{}]", section)));
    for (const Key& key : keys)
      if (key.section == section && !key.alias.empty() && table.contains(key.name) &&
          table.contains(key.alias))
        refuse(table.get(key.alias)->source(),
               fmt::format("{} is another name of {}, which is given, too; leave one out", key.alias,
                           full_name(key)));
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
    if (!number) refuse(key, node, "must be a number");
    if (!std::isfinite(*number)) refuse(key, node, "must be finite");
    if (*number < key.least || *number > key.most) refuse(key, node, range_of(key, *number));
    return *number;
  }
  static std::string range_of(const Key& key, double number) {
    if (std::isinf(key.most))
      return key.least > 0 && key.least < 1e-9
                 ? fmt::format("must be greater than 0, not {:g}", number)
                 : fmt::format("must be at least {:g}, not {:g}", key.least, number);
    return fmt::format("must lie between {:g} and {:g}; {:g} does not", key.least, key.most, number);
  }
  template <class Integer>
  [[nodiscard]] Integer integer_of(const Key& key, const toml::node& node) const {
    if (!node.is_integer()) refuse(key, node, "must be a whole number");
    const double number = number_of(key, node);
    if (number < static_cast<double>(std::numeric_limits<Integer>::min()) ||
        number > static_cast<double>(std::numeric_limits<Integer>::max()))
      refuse(key, node, fmt::format("is too large a number: {:g}", number));
    return static_cast<Integer>(number);
  }
  [[nodiscard]] std::string text_of(const Key& key, const toml::node& node) const {
    const std::optional<std::string> text = node.is_string() ? node.value<std::string>() : std::nullopt;
    if (!text) refuse(key, node, "must be a text in quotes");
    return *text;
  }
  [[nodiscard]] const toml::array& array_of(const Key& key, const toml::node& node, std::size_t count,
                                            const char* wanted) const {
    const toml::array* const array = node.as_array();
    if (array == nullptr || (count > 0 && array->size() != count))
      refuse(key, node, fmt::format("must be {}", wanted));
    return *array;
  }

  void take(const Key& key, const toml::node& node) const {
    std::visit([&](const auto& target) { set(key, node, target); }, key.target);
  }
  void set(const Key& key, const toml::node& node, bool* target) const {
    const std::optional<bool> value = node.is_boolean() ? node.value<bool>() : std::nullopt;
    if (!value) refuse(key, node, "must be true or false");
    *target = *value;
  }
  void set(const Key& key, const toml::node& node, int* target) const {
    *target = integer_of<int>(key, node);
  }
  void set(const Key& key, const toml::node& node, std::size_t* target) const {
    *target = integer_of<std::size_t>(key, node);
  }
  void set(const Key& key, const toml::node& node, double* target) const { *target = number_of(key, node); }
  void set(const Key& key, const toml::node& node, std::optional<double>* target) const {
    *target = number_of(key, node);
  }
  void set(const Key& key, const toml::node& node, std::string* target) const {
    *target = text_of(key, node);
  }
  void set(const Key& key, const toml::node& node, std::vector<int>* target) const {
    target->clear();
    for (const toml::node& item : array_of(key, node, 0, "a list of whole numbers, such as [1, 2]"))
      target->push_back(integer_of<int>(key, item));
  }
  void set(const Key& key, const toml::node& node, std::vector<std::string>* target) const {
    target->clear();
    if (node.is_string()) return target->push_back(text_of(key, node));  // A list of one.
    for (const toml::node& item : array_of(key, node, 0, "a list of texts, such as [\"mesh.vtu\"]"))
      target->push_back(text_of(key, item));
  }
  void set(const Key& key, const toml::node& node, std::vector<CutPlane>* target) const {
    target->clear();
    for (const toml::node& item :
         array_of(key, node, 0, "a list of planes, such as [[0, 0, 10, 0, 0, -1]]")) {
      std::vector<double> n;
      for (const toml::node& number :
           array_of(key, item, 6, "a list of planes of six numbers each, x y z nx ny nz"))
        n.push_back(number_of(key, number));
      target->push_back({Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])});
      if (target->back().normal.isZero(0)) refuse(key, item, "has a plane whose normal is zero");
    }
  }
  void set(const Key& key, const toml::node& node, std::vector<Vec3>* target) const {
    target->clear();
    for (const toml::node& item : array_of(key, node, 0, "a list of places, such as [[10, 20.5, 30]]")) {
      const toml::array& numbers = array_of(key, item, 3, "a list of places of three numbers each, x y z");
      target->emplace_back(number_of(key, numbers[0]), number_of(key, numbers[1]),
                           number_of(key, numbers[2]));
    }
  }
  void set(const Key& key, const toml::node& node, Index3* target) const {
    const toml::array& numbers = array_of(key, node, 3, "three whole numbers, such as [256, 256, 254]");
    for (int i = 0; i < 3; ++i) (*target)[i] = integer_of<int>(key, numbers[static_cast<std::size_t>(i)]);
  }
  void set(const Key& key, const toml::node& node, Vec3* target) const {
    if (node.is_number()) return target->setConstant(number_of(key, node)), void();
    const toml::array& numbers = array_of(key, node, 3, "a number, or three");
    for (int i = 0; i < 3; ++i) (*target)[i] = number_of(key, numbers[static_cast<std::size_t>(i)]);
  }
  void set(const Key& key, const toml::node& node, const Choice& choice) const {
    // The paper writes some choices as numbers.
    const std::optional<std::int64_t> number =
        node.is_integer() && !key.alias.empty() ? node.value<std::int64_t>() : std::nullopt;
    if (number && *number >= 0 && *number < static_cast<std::int64_t>(choice.words.size()))
      return choice.set(static_cast<std::size_t>(*number));
    const std::optional<std::string> word = node.is_string() ? node.value<std::string>() : std::nullopt;
    const auto found = std::find(choice.words.begin(), choice.words.end(), word);
    if (found == choice.words.end()) {
      std::string list;
      for (const std::string& known : choice.words)
        list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", known);
      refuse(key, node, fmt::format("must be one of {}{}", list, word ? ", not \"" + *word + "\"" : ""));
    }
    choice.set(static_cast<std::size_t>(found - choice.words.begin()));
  }
  void set(const Key& key, const toml::node& node, const FilePath& file) const {
    *file.path = text_of(key, node);
    if (file.path->empty() || std::find(file.words.begin(), file.words.end(), *file.path) != file.words.end())
      return;
    *file.path = std::filesystem::absolute(folder_ / *file.path).lexically_normal().string();
  }

  std::string name_;
  bool has_lines_;
  std::filesystem::path folder_;
};

bool is_text(const KeyTarget& target) {
  return std::holds_alternative<std::string*>(target) || std::holds_alternative<FilePath>(target);
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// As a TOML string.
std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

/// "metric.k=40" as a line of TOML. Quotes are not asked for: what a key of a text gets, and what is no value
/// of TOML, is a text.
void read_setting(const std::string& setting, const std::vector<Key>& keys) {
  const std::string how = "--set " + setting + ": write SECTION.KEY=VALUE, such as metric.k=40";
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) throw Error(ErrorKind::kUsage, how);
  const std::string name = trimmed(setting.substr(0, equals)), value = trimmed(setting.substr(equals + 1));
  if (std::any_of(keys.begin(), keys.end(), [&](const Key& key) { return key.section == name; }))
    throw Error(ErrorKind::kUsage, how);
  const auto key = std::find_if(keys.begin(), keys.end(), [&](const Key& one) {
    return name == (one.section.empty() ? one.name : one.section + "." + one.name);
  });
  bool takes_text = key != keys.end() && is_text(key->target);
  try {
    const toml::table table = toml::parse("value = " + value);
    takes_text = takes_text && !table["value"].is_string();
  } catch (const toml::parse_error&) {
    takes_text = true;
  }
  CaseReader("--set " + setting, false, std::filesystem::current_path())
      .read(name + " = " + (takes_text ? quoted(value) : value), keys);
}

}  // namespace
}  // namespace pipeline

Case read_case(const std::filesystem::path& path, std::span<const std::string> settings) {
  Case c;
  c.name = path.stem().string();
  c.file = path.string();
  const std::vector<pipeline::Key> keys = pipeline::keys_of(c);
  pipeline::CaseReader(c.file, true, path.parent_path()).read(read_text_file(path), keys);
  for (const std::string& setting : settings) pipeline::read_setting(setting, keys);
  naming(c.file, [&] { pipeline::check_case(c); });
  return c;
}

}  // namespace lumesh
