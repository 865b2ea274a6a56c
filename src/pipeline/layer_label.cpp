#include "lumesh/pipeline/layer_label.hpp"

#include <fmt/core.h>

#include <charconv>
#include <optional>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

std::optional<Label> whole_number(const std::string& text) {
  Label number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, number);
  return fault == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

}  // namespace

void take_layer_label(const std::string& text, LayerOptions& options) {
  if (text.empty()) return;
  const std::size_t equals = text.find('=');
  const bool has_both = equals != std::string::npos;
  const std::string number = has_both ? text.substr(equals + 1) : text;
  const std::optional<Label> label = whole_number(number);
  if (label && *label <= 0) throw Error(ErrorKind::kBadInput, "labels are above 0");
  if (label) options.label = *label;
  const bool looks_like_number =
      !number.empty() && number.find_first_not_of("+-.0123456789") == std::string::npos;
  if (equals == 0) throw Error(ErrorKind::kBadInput, "the name is missing; write NAME=NUMBER");
  if (!label && (has_both || looks_like_number))
    throw Error(ErrorKind::kBadInput, fmt::format("\"{}\" is no whole number; write NAME=NUMBER", number));
  if (!label || has_both) options.label_name = text.substr(0, equals);
}

}  // namespace lumesh
