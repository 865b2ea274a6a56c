#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/domain/extension.hpp"

namespace lumesh {
namespace {

[[noreturn]] void throw_bad_length(const std::string& text) {
  throw Error(ErrorKind::kUsage,
              "\"" + text + "\" is no length; give mm, such as 12.5, or local radii, such as 5r");
}

std::string text_of(const NamedLength& one) {
  return (one.opening.empty() ? "" : one.opening + "=") + one.length.text();
}

}  // namespace

std::string LocalLength::text() const {
  return fmt::format("{}{}", value, is_in_radii ? "r" : "");
}

bool LocalLength::is_valid() const {
  return std::isfinite(value) && value >= 0;
}

LocalLength local_length_from(const std::string& text) {
  const std::string_view whole = trimmed(text);
  const bool is_in_radii = whole.ends_with('r');
  const auto value = parse_number<double>(whole.substr(0, whole.size() - (is_in_radii ? 1 : 0)));
  const LocalLength length{value.value_or(-1), is_in_radii};
  if (!length.is_valid()) throw_bad_length(text);
  return length;
}

std::vector<NamedLength> named_lengths_from(const std::string& text) {
  std::vector<NamedLength> lengths;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.rfind('=');
    NamedLength one;
    if (equals != std::string::npos) {
      one.opening = trimmed(part.substr(0, equals));
      if (one.opening.empty())
        throw Error(ErrorKind::kUsage, "\"" + part +
                                           "\" names no opening; give a length for all, such as 5r, "
                                           "or an opening's, such as inlet_1=5r");
    }
    one.length = local_length_from(equals == std::string::npos ? part : part.substr(equals + 1));
    const bool is_twice =
        std::ranges::any_of(lengths, [&](const NamedLength& other) { return other.opening == one.opening; });
    if (is_twice)
      throw Error(ErrorKind::kUsage, one.opening.empty() ? "has two lengths for all openings"
                                                         : "has two lengths for " + one.opening);
    lengths.push_back(std::move(one));
    begin = end + 1;
  }
  return lengths;
}

double length_wanted_mm(std::span<const NamedLength> lengths, const std::vector<std::string>& names,
                        double radius_mm) {
  std::optional<double> for_all, named;
  for (const NamedLength& wanted : lengths) {
    const double length_mm = wanted.length.in_mm(radius_mm);
    if (wanted.opening.empty()) for_all = length_mm;
    if (std::ranges::find(names, wanted.opening) == names.end()) continue;
    if (named && *named != length_mm)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} and what is around it are one vessel, and have two lengths",
                              option_name("extend"), names.front()));
    named = length_mm;
  }
  const double length_mm = named ? *named : for_all.value_or(0);
  constexpr double kMaxRadii = 1000;
  if (!(length_mm <= kMaxRadii * radius_mm))
    throw Error(ErrorKind::kBadInput,
                fmt::format("{}: {} would go on by {:.3g} mm, more than {:g} times its radius",
                            option_name("extend"), names.front(), length_mm, kMaxRadii));
  return length_mm;
}

void check_names_of(std::span<const NamedLength> lengths, const std::vector<std::string>& openings,
                    const std::string& where) {
  for (const NamedLength& wanted : lengths)
    if (!wanted.opening.empty() && std::ranges::find(openings, wanted.opening) == openings.end())
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("{}: {} has no opening {}; it has {}", option_name("extend"), where, wanted.opening,
                      openings.empty() ? "none" : fmt::format("{}", fmt::join(openings, ", "))));
}

OptionParsed local_length_option(std::optional<LocalLength>& length) {
  return {[&length] { return length ? length->text() : ""; },
          [&length](const std::string& text) {
            length.reset();
            if (!text.empty()) length = local_length_from(text);
          }};
}

void ExtensionOptions::describe_lengths(OptionList& list) {
  list.parsed("extend",
              {[this] {
                 std::vector<std::string> texts;
                 for (const NamedLength& one : lengths) texts.push_back(text_of(one));
                 return fmt::format("{}", fmt::join(texts, ","));
               },
               [this](const std::string& text) {
                 lengths.clear();
                 if (!text.empty()) lengths = named_lengths_from(text);
               }},
              "Vessels go on straight beyond their openings, by a length each: of all (5r), of some "
              "(inlet_1=10r,outlet_2=0), or both; a number is in mm, with r in local radii");
}

void ExtensionOptions::describe(OptionList& list) {
  describe_lengths(list);
  list.parsed("extend_circle", local_length_option(transition),
              "Length over which the extension's section becomes a circle of its area; 0: at once")
      .by_default("the section is kept")
      .needs("extend");
}

void ExtensionOptions::validate() const {
  for (const NamedLength& one : lengths)
    if (!one.length.is_valid()) naming(option_name("extend"), [&] { throw_bad_length(text_of(one)); });
  if (transition && !transition->is_valid())
    naming(option_name("extend_circle"), [&] { throw_bad_length(transition->text()); });
}

}  // namespace lumesh
