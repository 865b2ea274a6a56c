#include "option_adapter.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option_words.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/io/file_formats.hpp"

namespace lumesh::cli {
namespace {

bool is_list(const OptionTarget& target) {
  return std::holds_alternative<OptionLabels>(target) ||
         std::holds_alternative<std::vector<std::string>*>(target) ||
         std::holds_alternative<std::map<int, double>*>(target) ||
         std::holds_alternative<OptionLabelledFiles>(target) ||
         (std::holds_alternative<OptionRows>(target) && !std::get<OptionRows>(target).is_single);
}

/// "Longer edges are split; metric length, between 1 and 3".
std::string help_of(const Option& option) {
  const std::string values = option.domain_text();
  return meaning_of(option) + (values.empty() ? "" : "; " + values) +
         (is_list(option.target) ? "; may be repeated" : "");
}

[[noreturn]] void throw_bad_value(const Option& option, const std::string& complaint) {
  throw CLI::ValidationError(flag_of(option.name), complaint);
}

/// The text as a number in the option's range. 0 for what is not given is taken only where another value is
/// the default: elsewhere leaving the option out says the same, and a 0 is a slip.
/// @param is_given_by_default  Whether the option has a value of its own without the command line.
template <class Number>
Number number_in_range(const Option& option, const std::string& text, bool is_given_by_default = false) {
  const std::optional<double> number = parse_number<double>(text);
  if (!number) throw_bad_value(option, fmt::format("\"{}\" is not a number", text));
  if (std::is_integral_v<Number> && *number != std::floor(*number))
    throw_bad_value(option, fmt::format("\"{}\" is not a whole number", text));
  const std::string complaint = (is_given_by_default ? option : option.without_zero()).complaint(*number);
  if (!complaint.empty()) throw_bad_value(option, complaint);
  if (std::is_integral_v<Number> &&
      std::abs(*number) > static_cast<double>(std::numeric_limits<Number>::max()))
    throw_bad_value(option, fmt::format("is too large a number: {}", text));
  return static_cast<Number>(*number == 0 && option.zero_text ? option.zero_value : *number);
}

/// The numbers of "X,Y,Z".
std::vector<double> row_from(const Option& option, const std::string& text, const OptionRows& rows) {
  std::optional<std::vector<double>> row = rows.row_from(text);
  if (!row)
    throw_bad_value(option, fmt::format("\"{}\" is not {} with commas between them, such as {}", text,
                                        rows.width_text(), rows.example));
  return std::move(*row);
}

/// Sets what may be no value.
template <class Set>
void set_or_throw(const Option& option, const Set& set) {
  try {
    set();
  } catch (const Error& senseless) {
    throw_bad_value(option, senseless.what());
  }
}

/// Makes the option of the command line for each kind of target.
class Adder {
 public:
  Adder(CLI::App& command, const Option& option) : command_(command), option_(option) {}

  CLI::Option* operator()(bool* target) const {
    const bool otherwise = !*target;
    return command_.add_flag_callback(
        flags_of(option_), [target, otherwise] { *target = otherwise; }, help_of(option_));
  }
  CLI::Option* operator()(int* target) const { return number(target, "INT"); }
  CLI::Option* operator()(std::size_t* target) const { return number(target, "INT"); }
  CLI::Option* operator()(double* target) const { return number(target, "NUMBER"); }
  CLI::Option* operator()(std::optional<double>* target) const {
    return text([target](const Option& o,
                         const std::string& value) { *target = number_in_range<double>(o, value, true); },
                "NUMBER")
        ->default_str(option_.default_text);
  }
  CLI::Option* operator()(std::string* target) const {
    return text([target](const Option&, const std::string& value) { *target = value; }, "TEXT");
  }
  CLI::Option* operator()(const OptionPath& path) const {
    return text([target = path.path](const Option&, const std::string& value) { *target = value; }, "FILE");
  }
  CLI::Option* operator()(const OptionParsed& parsed) const {
    return text(
        [parsed](const Option& o, const std::string& value) { set_or_throw(o, [&] { parsed.set(value); }); },
        "TEXT");
  }
  CLI::Option* operator()(const OptionWord& word) const {
    CLI::Option* const made = text(
        [word](const Option& o, const std::string& value) {
          const std::optional<std::size_t> index = word.index_of(value);
          if (!index) throw_bad_value(o, word.complaint(value));
          word.set(*index);
        },
        fmt::format("{}", fmt::join(word.words, "|")));
    return made->default_str(word.words[word.get()]);
  }
  CLI::Option* operator()(const OptionLabels& labels) const {
    return list(
               [words = labels.words](const Option& o, const std::string& value) {
                 if (trimmed(value).empty()) throw_bad_value(o, "must be numbers or names of labels");
                 words->emplace_back(trimmed(value));
               },
               "LABEL,...")
        ->delimiter(',');
  }
  CLI::Option* operator()(std::vector<std::string>* target) const {
    return list([target](const Option&, const std::string& value) { target->push_back(value); }, "TEXT");
  }
  CLI::Option* operator()(std::map<int, double>* target) const {
    return list(
        [target](const Option& o, const std::string& value) {
          const std::string complaint = add_label_number(value, o, *target);
          if (!complaint.empty()) throw_bad_value(o, complaint);
        },
        "LABEL=NUMBER");
  }
  CLI::Option* operator()(const OptionLabelledFiles& labelled) const {
    return list(
        [files = labelled.files](const Option& o, const std::string& value) {
          const std::string complaint = add_labelled_file(value, *files);
          if (!complaint.empty()) throw_bad_value(o, complaint);
        },
        "FILE=LABEL");
  }
  CLI::Option* operator()(const OptionRows& rows) const {
    if (!rows.are_words()) return rows_of_commas(rows);
    return rows.is_single ? row_of_words(rows) : rows_of_words(rows);
  }

 private:
  using Take = std::function<void(const Option&, const std::string&)>;

  template <class Number>
  CLI::Option* number(Number* target, const char* type) const {
    const bool is_given = option_.number() != std::optional(0.0);
    return text(
               [target, is_given](const Option& o, const std::string& value) {
                 *target = number_in_range<Number>(o, value, is_given);
               },
               type)
        ->default_str(option_.value_text());
  }
  CLI::Option* text(const Take& take, const std::string& type) const {
    return command_
        .add_option_function<std::string>(
            flags_of(option_), [option = option_, take](const std::string& value) { take(option, value); },
            help_of(option_))
        ->type_name(type);
  }
  CLI::Option* list(const Take& take, const std::string& type) const {
    return command_
        .add_option_function<std::vector<std::string>>(
            flags_of(option_),
            [option = option_, take](const std::vector<std::string>& values) {
              for (const std::string& value : values) take(option, value);
            },
            help_of(option_))
        ->allow_extra_args(false)
        ->type_name(type);
  }
  void set_rows(const OptionRows& rows, const std::vector<std::vector<double>>& values) const {
    set_or_throw(option_, [&] { rows.set(values); });
  }
  /// Exactly one row, a word for each number; a number alone fills a row without a least count.
  CLI::Option* row_of_words(const OptionRows& rows) const {
    const auto width = static_cast<int>(rows.width);
    return command_
        .add_option_function<std::vector<double>>(
            flags_of(option_),
            [self = *this, rows](std::vector<double> row) {
              for (const double number : row)
                if (const std::string complaint = self.option_.without_zero().complaint(number);
                    !complaint.empty())
                  throw_bad_value(self.option_, complaint);
              if (row.size() == 1) row.resize(rows.width, row.front());
              if (!rows.takes(row.size()))
                throw_bad_value(self.option_, fmt::format("needs {}, or one for all, not {}",
                                                          rows.width_text(), row.size()));
              self.set_rows(rows, {std::move(row)});
            },
            help_of(option_))
        ->expected(rows.least == 0 ? 1 : width, width)
        ->default_str(option_.value_text());
  }
  CLI::Option* rows_of_words(const OptionRows& rows) const {
    return command_
        .add_option_function<std::vector<std::vector<double>>>(
            flags_of(option_),
            [self = *this, rows](const std::vector<std::vector<double>>& values) {
              const auto width = static_cast<std::ptrdiff_t>(rows.width);
              std::vector<std::vector<double>> numbers;  // Several rows may follow one option.
              for (const std::vector<double>& row : values) {
                if (!std::ranges::all_of(row, [](double x) { return std::isfinite(x); }))
                  throw_bad_value(self.option_, "needs finite numbers");
                if (row.size() % rows.width != 0)
                  throw_bad_value(self.option_,
                                  fmt::format("needs {} numbers for each, not {}", rows.width, row.size()));
                for (auto at = row.begin(); at != row.end(); at += width)
                  numbers.emplace_back(at, at + width);
              }
              self.set_rows(rows, numbers);
            },
            help_of(option_))
        ->type_size(static_cast<int>(rows.width));
  }
  CLI::Option* rows_of_commas(const OptionRows& rows) const {
    return command_
        .add_option_function<std::vector<std::string>>(
            flags_of(option_),
            [self = *this, rows](const std::vector<std::string>& values) {
              std::vector<std::vector<double>> numbers;
              for (const std::string& value : values) numbers.push_back(row_from(self.option_, value, rows));
              self.set_rows(rows, numbers);
            },
            help_of(option_))
        ->allow_extra_args(false)
        ->type_name(rows.placeholder);
  }

  CLI::App& command_;
  Option option_;
};

}  // namespace

std::string flags_of(const Option& option) {
  const auto* const target = std::get_if<bool*>(&option.target);
  if (target != nullptr && **target) return flag_of("no_" + option.name);
  std::vector<std::string> flags = {flag_of(option.name)};
  for (const std::string& alias : option.aliases)
    flags.insert(alias.size() == 1 ? flags.begin() : flags.end(),
                 alias.size() == 1 ? "-" + alias : flag_of(alias));
  if (is_list(option.target)) std::ranges::reverse(flags);
  return fmt::format("{}", fmt::join(flags, ","));
}

void add_options(CLI::App& command, const OptionList& list, const std::string& group,
                 std::initializer_list<std::string_view> without) {
  std::vector<std::pair<const Option*, CLI::Option*>> made;
  for (const Option& option : list.all()) {
    if (std::ranges::find(without, option.name) != without.end()) continue;
    made.emplace_back(&option, std::visit(Adder(command, option), option.target));
    if (!group.empty()) made.back().second->group(group);
  }
  const auto called = [&](const std::string& name) { return command.get_option_no_throw(flag_of(name)); };
  for (const auto& [option, flag] : made) {
    for (const std::string& other : option->excluded)
      if (CLI::Option* const excluded = called(other)) flag->excludes(excluded);
    for (const std::string& other : option->needed)
      if (CLI::Option* const needed = called(other)) flag->needs(needed);
  }
}

void require_not_given(const CLI::App& command, const OptionList& list, const std::string& reason,
                       std::initializer_list<std::string_view> without) {
  for (const Option& option : list.all()) {
    if (std::ranges::find(without, option.name) != without.end()) continue;
    const CLI::Option* const flag = command.get_option_no_throw(flag_of(option.name));
    if (flag != nullptr && flag->count() > 0)
      throw Error(ErrorKind::kUsage, fmt::format("{} {}; leave it out", option_name(option.name), reason));
  }
}

std::string with_flags(std::string_view message, const CLI::App& command) {
  const auto has = [](const CLI::App& of, const std::string& flag) {
    return of.get_option_no_throw(flag) != nullptr;
  };
  const auto is_any = [&](const std::string& flag) {
    if (has(command, flag) || command.get_parent() == nullptr) return has(command, flag);
    const std::vector<const CLI::App*> others = command.get_parent()->get_subcommands({});
    return std::ranges::any_of(others, [&](const CLI::App* other) { return has(*other, flag); });
  };
  return with_spelled_options(message, [&](std::string_view name) {
    const std::string flag = flag_of(name);
    return is_any(flag) ? flag : "";
  });
}

}  // namespace lumesh::cli
