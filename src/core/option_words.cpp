#include "lumesh/core/option_words.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <sstream>
#include <type_traits>
#include <variant>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// The shortest text that reads as the same number.
std::string exact_text(double number) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

/// Texts of the items with a character between them.
template <class Item, class Text>
std::string row_text(std::span<const Item> items, char between, const Text& text) {
  std::string row;
  for (const Item& item : items) row += (row.empty() ? std::string() : std::string(1, between)) + text(item);
  return row;
}

/// Words of one option, of which rows come one after the other.
void take_values(std::span<const std::string> values, const OptionRows& rows) {
  std::vector<std::vector<double>> all = rows.get();
  const std::size_t words = rows.are_words() ? rows.width : 1;
  for (; values.size() >= words; values = values.subspan(words)) {
    const std::string row = row_text(values.first(words), ',', [](const std::string& word) { return word; });
    if (std::optional<std::vector<double>> numbers = rows.row_from(row)) all.push_back(std::move(*numbers));
  }
  rows.set(all);
}

/// Empties the target of an option, each kind in its own way. False for those that are never empty.
struct NoneTaker {
  const Option& option;

  bool operator()(bool*) const { return false; }
  bool operator()(const OptionWord&) const { return false; }
  template <class Number>
  bool operator()(Number* number) const requires std::is_arithmetic_v<Number> {
    const bool may_be_none = option.zero_text == "none";
    if (may_be_none) *number = static_cast<Number>(option.zero_value);
    return may_be_none;
  }
  bool operator()(std::optional<double>* number) const {
    number->reset();
    return true;
  }
  template <class Items>
  bool operator()(Items* items) const requires requires {
    items->clear();
  }
  {
    items->clear();
    return true;
  }
  bool operator()(const OptionPath& path) const {
    if (std::ranges::find(path.words, "none") != path.words.end()) return false;
    path.path->clear();
    return true;
  }
  bool operator()(const OptionParsed& parsed) const {
    parsed.set("");
    return true;
  }
  bool operator()(const OptionRows& rows) const {
    if (rows.may_be_none) rows.set({});
    return rows.may_be_none;
  }
  bool operator()(const OptionLabels& labels) const {
    labels.words->clear();
    return true;
  }
  bool operator()(const OptionLabelledFiles& labelled) const {
    labelled.files->clear();
    return true;
  }
};

void take_values(const std::vector<std::string>& values, const Option& option) {
  if (values.empty()) return;
  try {
    if (const auto* const rows = std::get_if<OptionRows>(&option.target)) take_values(values, *rows);
    if (const auto* const parsed = std::get_if<OptionParsed>(&option.target)) parsed->set(values.front());
  } catch (const Error&) {  // No such value.
  }
}

}  // namespace

std::string flag_of(std::string_view name) {
  std::string flag = "--" + std::string(name);
  std::ranges::replace(flag, '_', '-');
  return flag;
}

std::vector<std::string> option_words(const OptionList& list) {
  std::vector<std::string> words;
  for (const Option& option : list.all()) {
    const std::string flag = flag_of(option.aliases.empty() ? option.name : option.aliases.front());
    if (const auto* const rows = std::get_if<OptionRows>(&option.target))
      for (const std::vector<double>& row : rows->get())
        words.push_back(flag + " " +
                        row_text(std::span<const double>(row), rows->are_words() ? ' ' : ',', exact_text));
    if (const auto* const parsed = std::get_if<OptionParsed>(&option.target))
      if (const std::string text = parsed->get(); !text.empty()) words.push_back(flag + " " + text);
  }
  return words;
}

bool take_none(const Option& option) {
  return std::visit(NoneTaker{option}, option.target);
}

void take_option_words(const std::string& words, const OptionList& list) {
  std::istringstream stream(words);
  const Option* option = nullptr;
  std::vector<std::string> values;
  const auto take = [&] {
    if (option != nullptr) take_values(values, *option);
    values.clear();
  };
  for (std::string word; stream >> word;) {
    if (!word.starts_with("--")) {
      values.push_back(word);
      continue;
    }
    take();
    const auto is_meant = [&](const Option& one) {
      return flag_of(one.name) == word || std::ranges::any_of(one.aliases, [&](const std::string& alias) {
               return flag_of(alias) == word;
             });
    };
    const auto found = std::ranges::find_if(list.all(), is_meant);
    option = found == list.all().end() ? nullptr : &*found;
  }
  take();
}

}  // namespace lumesh
