#include "lumesh/core/option.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "lumesh/core/error.hpp"
#include "lumesh/core/joined.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/trimmed.hpp"

namespace lumesh {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

std::string text_of(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

std::string or_none(const std::string& text) {
  return text.empty() ? "none" : text;
}

template <class Items, class Text>
std::string joined_or_none(const Items& items, const Text& text) {
  return or_none(joined(items, text));
}

void require_in_range(const Option& option, double value) {
  const std::string complaint = option.complaint(value);
  if (!complaint.empty()) throw Error(ErrorKind::kUsage, option_name(option.name) + " " + complaint);
}

}  // namespace

bool OptionRange::contains(double value) const {
  if (includes_infinity && value == std::numeric_limits<double>::infinity()) return true;
  return std::isfinite(value) && value <= max && (excludes_min ? value > min : value >= min);
}

std::string OptionRange::text() const {
  if (excludes_min && std::isfinite(max))
    return "greater than " + text_of(min) + " and at most " + text_of(max);
  if (min == max) return text_of(min);
  if (std::isfinite(min) && std::isfinite(max)) return "between " + text_of(min) + " and " + text_of(max);
  if (std::isfinite(max)) return "at most " + text_of(max);
  if (!std::isfinite(min)) return "";
  return (excludes_min ? "greater than " : "at least ") + text_of(min) +
         (includes_infinity ? ", or inf" : "");
}

std::optional<std::size_t> OptionWord::index_of(std::string_view text) const {
  const auto synonym = synonyms.find(text);
  const auto found = std::ranges::find(words, synonym == synonyms.end() ? text : synonym->second);
  if (found == words.end()) return std::nullopt;
  return static_cast<std::size_t>(found - words.begin());
}

std::string OptionWord::complaint(std::string_view text) const {
  return "must be one of " + joined(words, [](const std::string& word) { return '"' + word + '"'; }) +
         ", not \"" + std::string(text) + '"';
}

std::string OptionRows::width_text() const {
  return (least > 0 && least < width ? std::to_string(least) + " to " : "") + std::to_string(width) +
         " numbers";
}

bool OptionRows::are_words() const {
  constexpr std::size_t kMaxInOneWord = 3;
  return width > kMaxInOneWord || (is_single && (least == 0 || least == width));
}

std::optional<std::vector<double>> OptionRows::row_from(std::string_view text) const {
  std::vector<double> row;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::optional<double> number = parse_number<double>(trimmed(text.substr(begin, end - begin)));
    if (!number || !std::isfinite(*number)) return std::nullopt;
    row.push_back(*number);
    begin = end + 1;
  }
  return takes(row.size()) ? std::optional(row) : std::nullopt;
}

bool Option::is_called(std::string_view text) const {
  return name == text || std::ranges::find(aliases, text) != aliases.end();
}

Option Option::without_zero() const {
  Option wanted = *this;
  wanted.zero_text.reset();
  return wanted;
}

std::string Option::complaint(double value) const {
  if ((value == 0 && zero_text) || range.contains(value)) return "";
  const std::string words = range.text();
  if (words.empty()) return "must be finite";
  const bool lies = words.starts_with("between");
  return (lies ? "must lie " : "must be ") + words + (zero_text ? ", or 0" : "") +
         (lies ? ", not at " : ", not ") + text_of(value);
}

std::string Option::domain_text() const {
  const std::string words = range.text();
  return unit + (unit.empty() || words.empty() ? "" : ", ") + words;
}

std::optional<double> Option::number() const {
  return std::visit(
      Overloaded{[](int* v) { return std::optional<double>(*v); },
                 [](std::size_t* v) { return std::optional<double>(static_cast<double>(*v)); },
                 [&](double* v) { return std::optional<double>(zero_text && *v == zero_value ? 0 : *v); },
                 [](std::optional<double>* v) { return *v; },
                 [](const auto&) { return std::optional<double>(); }},
      target);
}

std::string Option::value_text() const {
  const auto as_text = [](const std::string& text) { return text; };
  if (const std::optional<double> value = number())
    return *value == 0 && zero_text ? *zero_text : text_of(*value);
  return std::visit(
      Overloaded{
          [](bool* v) { return std::string(*v ? "on" : "off"); }, [](std::string* v) { return or_none(*v); },
          [&](const OptionLabels& labels) { return joined_or_none(*labels.words, as_text); },
          [&](std::vector<std::string>* v) { return joined_or_none(*v, as_text); },
          [](std::map<int, double>* v) {
            return joined_or_none(
                *v, [](const auto& pair) { return std::to_string(pair.first) + "=" + text_of(pair.second); });
          },
          [](const OptionWord& word) { return word.words[word.get()]; },
          [](const OptionPath& path) { return or_none(*path.path); },
          [](const OptionParsed& parsed) { return or_none(parsed.get()); },
          [&](const OptionRows& rows) {
            const auto values = rows.get();
            const auto is_zero = [](double number) { return number == 0; };
            if (zero_text && rows.is_single && std::ranges::all_of(values.front(), is_zero))
              return *zero_text;
            return joined_or_none(
                values, [](const std::vector<double>& row) { return "[" + joined(row, text_of) + "]"; });
          },
          [](const OptionLabelledFiles& labelled) {
            return joined_or_none(*labelled.files, [](const auto& file) {
              return file.first + "=" + std::to_string(file.second);
            });
          },
          [&](const auto&) { return or_none(default_text); }},
      target);
}

std::string add_label_number(std::string_view text, const Option& option, std::map<int, double>& numbers) {
  const std::size_t equals = std::min(text.find('='), text.size());
  const auto label = parse_number<int>(text.substr(0, equals));
  const auto number = parse_number<double>(text.substr(std::min(equals + 1, text.size())));
  if (!label || !number) return '"' + std::string(text) + "\" is not LABEL=NUMBER, such as 2=0.4";
  const std::string complaint = option.complaint(*number);
  if (!complaint.empty()) return '"' + std::string(text) + "\" " + complaint;
  if (!numbers.emplace(*label, *number).second) return "label " + std::to_string(*label) + " is given twice";
  return "";
}

std::string add_labelled_file(std::string_view text, LabelledFiles& files) {
  const std::size_t equals = text.rfind('=');
  const auto label =
      equals == std::string_view::npos ? std::nullopt : parse_number<int>(text.substr(equals + 1));
  if (!label || equals == 0) return '"' + std::string(text) + "\" is not FILE=LABEL, such as wall.nrrd=2";
  if (*label <= 0) return '"' + std::string(text) + "\" has a label that is not positive";
  files.emplace_back(text.substr(0, equals), *label);
  return "";
}

void require_ranges(const OptionList& list) {
  for (const Option& option : list.all()) {
    const auto require = [&](double value) { require_in_range(option, value); };
    if (const std::optional<double> value = option.number()) require(*value);
    if (const auto* const of_labels = std::get_if<std::map<int, double>*>(&option.target))
      for (const auto& entry : **of_labels) require(entry.second);
    if (const auto* const rows = std::get_if<OptionRows>(&option.target))
      for (const std::vector<double>& row : rows->get()) std::ranges::for_each(row, require);
  }
}

void require_given(const OptionList& list, std::string_view name) {
  const auto at = std::ranges::find(list.all(), name, &Option::name);
  const Option option = at->without_zero();
  require_in_range(option, option.number().value_or(std::numeric_limits<double>::quiet_NaN()));
}

std::string option_name(std::string_view name) {
  return '`' + std::string(name) + '`';
}

std::string with_spelled_options(std::string_view message,
                                 const std::function<std::string(std::string_view)>& spelling) {
  std::string text;
  while (!message.empty()) {
    const std::size_t open = message.find('`');
    const std::size_t close = open == std::string_view::npos ? open : message.find('`', open + 1);
    if (close == std::string_view::npos) break;
    const std::string spelled = spelling(message.substr(open + 1, close - open - 1));
    text += message.substr(0, open);
    text += spelled.empty() ? message.substr(open, close - open + 1) : spelled;
    message.remove_prefix(close + 1);
  }
  return text += message;
}

}  // namespace lumesh
