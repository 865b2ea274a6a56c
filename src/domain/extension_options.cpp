#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/domain/extension.hpp"

namespace lumesh {
LocalLength local_length_from(const std::string& text) {
  std::string number(trimmed(text));
  LocalLength length;
  length.is_in_radii = number.ends_with('r');
  if (length.is_in_radii) number.pop_back();
  const char* const end = number.data() + number.size();
  const auto [rest, fault] = std::from_chars(number.data(), end, length.value);
  if (fault != std::errc() || rest != end || !std::isfinite(length.value) || length.value < 0)
    throw Error(ErrorKind::kUsage,
                "\"" + text + "\" is no length; give mm, such as 12.5, or local radii, such as 5r");
  return length;
}

std::vector<NamedLength> named_lengths_from(const std::string& text) {
  std::vector<NamedLength> lengths;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.rfind('=');
    NamedLength one;
    if (equals != std::string::npos) one.opening = trimmed(part.substr(0, equals));
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

void ExtensionOptions::describe_lengths(OptionList& list) {
  list.text("extend", lengths,
            "Vessels go on straight beyond their openings, by a length each: of all (5r), of some "
            "(inlet_1=10r,outlet_2=0), or both; a number is in mm, with r in local radii")
      .by_default("none");
}

void ExtensionOptions::describe(OptionList& list) {
  describe_lengths(list);
  list.text("extend_circle", transition,
            "Length over which the extension's section becomes a circle of its area; 0: at once")
      .by_default("the section is kept")
      .needs("extend");
}

void ExtensionOptions::validate() const {
  if (is_wanted()) naming(option_name("extend"), [&] { static_cast<void>(named_lengths_from(lengths)); });
  if (!transition.empty())
    naming(option_name("extend_circle"), [&] { static_cast<void>(local_length_from(transition)); });
}

}  // namespace lumesh
